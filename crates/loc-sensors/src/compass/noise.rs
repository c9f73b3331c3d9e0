//! What leads a compass astray.

use crate::Result;
use loc_core::error::{finite, non_negative, positive};
use nalgebra::{Point2, Vector2};

/// Errors of the device itself.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct CompassNoise {
    /// Standard deviation of each component of the field \[uT\]; that of the heading is this by the
    /// strength of the horizontal field.
    pub sigma: f64,
    /// Field of the robot's own iron, which turns with it, forward and left \[uT\].
    pub hard_iron: [f64; 2],
}

impl CompassNoise {
    /// A perfect compass.
    pub const NONE: CompassNoise = CompassNoise { sigma: 0.0, hard_iron: [0.0; 2] };

    /// Honeywell HMC5883L: a field resolution of 2 mG (0.2 uT) by its data sheet, taken for the
    /// standard deviation; 0.6 deg in a field of 20 uT. Calibrated iron.
    pub fn hmc5883l() -> Self {
        CompassNoise { sigma: 0.2, hard_iron: [0.0; 2] }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a negative sigma, NaN and infinity.
    pub fn check(&self) -> Result<()> {
        non_negative("sigma of the magnetic field [uT]", self.sigma)?;
        for component in self.hard_iron {
            finite("field of the robot's iron [uT]", component)?;
        }
        Ok(())
    }
}

/// Something magnetic in the world: its field is added to the Earth's, strongest in the middle,
/// `field exp(-distance^2 / 2 radius^2)`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Disturbance {
    /// Its middle in the map \[m\].
    pub center: [f64; 2],
    /// How far it reaches \[m\].
    pub radius: f64,
    /// Its field in the middle, along the axes of the map \[uT\].
    pub field: [f64; 2],
}

impl Disturbance {
    /// Its field at a place of the map \[uT\].
    pub fn at(&self, place: &Point2<f64>) -> Vector2<f64> {
        let distance = (place - Point2::from(self.center)).norm() / self.radius;
        Vector2::from(self.field) * (-0.5 * distance * distance).exp()
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a radius that is not positive, NaN and infinity.
    pub fn check(&self) -> Result<()> {
        for value in self.center {
            finite("middle of a magnetic disturbance [m]", value)?;
        }
        positive("radius of a magnetic disturbance [m]", self.radius)?;
        for value in self.field {
            finite("field of a magnetic disturbance [uT]", value)?;
        }
        Ok(())
    }
}
