//! How far a range may be off, and what else goes wrong with beams.

use crate::Result;
use crate::check::in_range;
use loc_core::error::{non_negative, probability};

/// Normal errors of the range.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct LaserNoise {
    /// Standard deviation of a range at the scanner \[m\].
    pub sigma: f64,
    /// Its growth with the range \[m/m\].
    pub sigma_per_m: f64,
}

impl LaserNoise {
    /// A perfect scanner.
    pub const NONE: LaserNoise = LaserNoise { sigma: 0.0, sigma_per_m: 0.0 };

    /// Standard deviation of a range of `range` \[m\].
    pub fn sigma_at(&self, range: f64) -> f64 {
        self.sigma + self.sigma_per_m * range
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for negative values, NaN and infinity.
    pub fn check(&self) -> Result<()> {
        non_negative("sigma of a laser's range [m]", self.sigma)?;
        non_negative("growth of a laser's sigma [m/m]", self.sigma_per_m)?;
        Ok(())
    }
}

/// What goes wrong with single beams, each with a probability. [`LaserFaults::NONE`] is a scanner
/// in a clean room.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct LaserFaults {
    /// The light does not come back (a black or shining surface): +inf.
    pub dropout: f64,
    /// The scanner reports an error (sunlight): NaN.
    pub erroneous: f64,
    /// Something that is on no map stands in the way (a person): any shorter range.
    pub short: f64,
}

impl LaserFaults {
    /// No faults.
    pub const NONE: LaserFaults = LaserFaults { dropout: 0.0, erroneous: 0.0, short: 0.0 };

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for probabilities outside \[0, 1\] or with a sum above 1.
    pub fn check(&self) -> Result<()> {
        probability("probability of a dropout", self.dropout)?;
        probability("probability of an erroneous beam", self.erroneous)?;
        probability("probability of a short beam", self.short)?;
        let sum = self.dropout + self.erroneous + self.short;
        in_range("sum of a laser's fault probabilities", "at most 1", sum, |sum| sum <= 1.0)?;
        Ok(())
    }
}
