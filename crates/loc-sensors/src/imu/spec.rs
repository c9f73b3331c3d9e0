//! What data sheets say of inertial measurement units.

use super::{InertialNoise, STANDARD_GRAVITY};
use crate::Result;
use loc_core::error::positive;

/// Rate and errors of an inertial measurement unit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct ImuSpec {
    /// Samples per second \[Hz\].
    pub rate: f64,
    /// Errors of each accelerometer \[m/s^2\].
    pub accelerometer: InertialNoise,
    /// Errors of each gyroscope \[rad/s\].
    pub gyroscope: InertialNoise,
}

impl ImuSpec {
    /// Analog Devices ADIS16448, a calibrated industrial unit, with the four densities that the
    /// EuRoC data sets (Burri et al. 2016) state for it; 18 g and 1000 deg/s.
    pub fn adis16448() -> Self {
        ImuSpec {
            rate: 200.0,
            accelerometer: InertialNoise {
                density: 2.0e-3,
                bias_walk: 3.0e-3,
                start_bias: 0.0,
                limit: 18.0 * STANDARD_GRAVITY,
            },
            gyroscope: InertialNoise {
                density: 1.6968e-4,
                bias_walk: 1.9393e-5,
                start_bias: 0.0,
                limit: 1000_f64.to_radians(),
            },
        }
    }

    /// InvenSense MPU-6050, the unit of hobby robots: 400 ug/sqrt(Hz), 0.005 deg/s/sqrt(Hz), in
    /// its ranges 2 g and 250 deg/s.
    ///
    /// The data sheet gives no bias walk, and offsets (50 mg, 20 deg/s) that any driver takes out
    /// while the robot stands: walk and what is left at start are assumptions of the usual size.
    pub fn mpu6050() -> Self {
        ImuSpec {
            rate: 100.0,
            accelerometer: InertialNoise {
                density: 400e-6 * STANDARD_GRAVITY,
                bias_walk: 5e-4,
                start_bias: 0.02,
                limit: 2.0 * STANDARD_GRAVITY,
            },
            gyroscope: InertialNoise {
                density: 0.005_f64.to_radians(),
                bias_walk: 2e-5,
                start_bias: 0.02_f64.to_radians(),
                limit: 250_f64.to_radians(),
            },
        }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a rate that is not positive, and those of
    /// [`InertialNoise::check`].
    pub fn check(&self) -> Result<()> {
        positive("samples per second of an IMU [Hz]", self.rate)?;
        self.accelerometer.check()?;
        self.gyroscope.check()
    }
}

impl Default for ImuSpec {
    /// The [`ImuSpec::mpu6050`].
    fn default() -> Self {
        ImuSpec::mpu6050()
    }
}
