//! The measurement: one sample.

use crate::Result;
use loc_core::error::finite;
use nalgebra::Vector3;

/// One sample in the device's frame: x forward, y left, z up.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ImuReading {
    /// Specific force: acceleration less gravity, +g along z at rest \[m/s^2\].
    pub acceleration: Vector3<f64>,
    /// Turn rates about the axes \[rad/s\].
    pub angular_velocity: Vector3<f64>,
}

impl ImuReading {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for NaN and infinity.
    pub fn check(&self) -> Result<()> {
        for value in self.acceleration.iter() {
            finite("acceleration [m/s^2]", *value)?;
        }
        for value in self.angular_velocity.iter() {
            finite("turn rate [rad/s]", *value)?;
        }
        Ok(())
    }
}
