//! How far an echo may be off, and which are missing or false.

use crate::Result;
use crate::check::in_range;
use loc_core::error::{non_negative, probability};

/// Independent normal errors of the three numbers, misses and false echoes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct RadarNoise {
    /// Standard deviation of the distance \[m\].
    pub range_sigma: f64,
    /// Standard deviation of the direction \[rad\].
    pub bearing_sigma: f64,
    /// Standard deviation of the radial speed \[m/s\].
    pub speed_sigma: f64,
    /// Probability that an object in view gives an echo.
    pub detection_probability: f64,
    /// How many false echoes there are in a measurement on average, evenly spread over distance,
    /// direction and speed.
    pub clutter: f64,
}

impl RadarNoise {
    /// A perfect radar.
    pub const NONE: RadarNoise = RadarNoise {
        range_sigma: 0.0,
        bearing_sigma: 0.0,
        speed_sigma: 0.0,
        detection_probability: 1.0,
        clutter: 0.0,
    };

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for negative values, NaN and infinity, a probability outside
    /// \[0, 1\], and more than 1000 false echoes.
    pub fn check(&self) -> Result<()> {
        non_negative("sigma of a radar's range [m]", self.range_sigma)?;
        non_negative("sigma of a radar's bearing [rad]", self.bearing_sigma)?;
        non_negative("sigma of a radar's radial speed [m/s]", self.speed_sigma)?;
        probability("detection probability of a radar", self.detection_probability)?;
        let few = |count: f64| (0.0..=1000.0).contains(&count);
        in_range("false echoes of a radar", "0 to 1000", self.clutter, few)?;
        Ok(())
    }
}
