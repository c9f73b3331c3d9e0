//! The measurement: one echo.

use crate::Result;
use loc_core::error::{finite, non_negative};

/// One echo as the radar reports it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RadarReturn {
    /// Distance \[m\].
    pub range: f64,
    /// Direction, counter-clockwise from the radar's axis \[rad\].
    pub bearing: f64,
    /// How fast the distance grows, negative for what approaches \[m/s\].
    pub radial_speed: f64,
}

impl RadarReturn {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a negative distance, NaN and infinity.
    pub fn check(&self) -> Result<()> {
        non_negative("range of a radar echo [m]", self.range)?;
        finite("bearing of a radar echo [rad]", self.bearing)?;
        finite("radial speed of a radar echo [m/s]", self.radial_speed)?;
        Ok(())
    }
}
