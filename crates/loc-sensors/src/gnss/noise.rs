//! How far a position may be off, and when there is none.

use crate::Result;
use loc_core::error::{non_negative, positive};

/// Errors of a position: a part that is new with every fix, and one that drifts (satellites,
/// ionosphere), a first-order Gauss-Markov process.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct GnssNoise {
    /// Standard deviation of the new part, east and north \[m\].
    pub white_sigma: f64,
    /// Standard deviation of the drifting part, east and north \[m\].
    pub drift_sigma: f64,
    /// Time in which the drift forgets all but 1/e of itself \[s\].
    pub drift_time: f64,
    /// Factor of the vertical errors.
    pub vertical_factor: f64,
}

impl GnssNoise {
    /// A perfect receiver.
    pub const NONE: GnssNoise =
        GnssNoise { white_sigma: 0.0, drift_sigma: 0.0, drift_time: 1.0, vertical_factor: 1.0 };

    /// u-blox NEO-M8: position accuracy 2.5 m CEP by its data sheet, which is 2.1 m standard
    /// deviation in each direction. That most of it drifts within minutes is the nature of the
    /// error; the shares are an assumption.
    pub fn neo_m8() -> Self {
        GnssNoise { white_sigma: 0.6, drift_sigma: 2.0, drift_time: 120.0, vertical_factor: 1.5 }
    }

    /// Standard deviation of the whole error, east and north \[m\].
    pub fn sigma(&self) -> f64 {
        f64::hypot(self.white_sigma, self.drift_sigma)
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for negative values, NaN, infinity, and a drift time that is
    /// not positive.
    pub fn check(&self) -> Result<()> {
        non_negative("white sigma of a position [m]", self.white_sigma)?;
        non_negative("drift sigma of a position [m]", self.drift_sigma)?;
        positive("time constant of a position's drift [s]", self.drift_time)?;
        non_negative("factor of vertical errors", self.vertical_factor)?;
        Ok(())
    }
}

/// Times without a position, such as under bridges: they begin at random and last at random, both
/// exponentially distributed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Outages {
    /// How many begin per second \[1/s\].
    pub rate: f64,
    /// How long one lasts on average \[s\].
    pub mean_duration: f64,
}

impl Outages {
    /// None at all.
    pub const NONE: Outages = Outages { rate: 0.0, mean_duration: 1.0 };

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a negative rate, or a duration that is not positive.
    pub fn check(&self) -> Result<()> {
        non_negative("outages per second [1/s]", self.rate)?;
        positive("mean duration of outages [s]", self.mean_duration)?;
        Ok(())
    }

    /// Probability that the receiver is out of service `dt` \[s\] after it was (`true`) or was not
    /// (`false`): the exact transition of the two-state process.
    pub fn probability_after(&self, out: bool, dt: f64) -> f64 {
        let recovery = 1.0 / self.mean_duration;
        let settled = self.rate / (self.rate + recovery);
        let start = if out { 1.0 } else { 0.0 };
        settled + (start - settled) * (-(self.rate + recovery) * dt).exp()
    }
}
