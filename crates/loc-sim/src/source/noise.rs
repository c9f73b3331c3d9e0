//! Noise of the sensors, in the units of configuration files.

use crate::Result;
use loc_core::motion::VelocityNoise;
use loc_sensors::landmark_camera::LandmarkNoise;
use serde::Deserialize;

/// The error model of odometry (E7), as standard deviations.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OdometryNoiseConfig {
    /// Of the distance, after 1 m.
    pub distance_sigma_m: f64,
    /// Of the heading, after a full turn.
    pub turn_sigma_deg: f64,
    /// Of the heading, after 1 m.
    pub drift_sigma_deg: f64,
}

/// Noise of a landmark camera, as standard deviations.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObservationNoiseConfig {
    /// Of the distance, at the camera.
    pub range_sigma_m: f64,
    /// Its growth with the distance.
    #[serde(default)]
    pub range_sigma_per_m: f64,
    /// Of the direction.
    pub bearing_sigma_deg: f64,
}

impl OdometryNoiseConfig {
    /// The library's form.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub fn noise(&self) -> Result<VelocityNoise> {
        let [turn, drift] = [self.turn_sigma_deg, self.drift_sigma_deg].map(f64::to_radians);
        Ok(VelocityNoise::from_sigmas(self.distance_sigma_m, turn, drift)?)
    }
}

impl ObservationNoiseConfig {
    /// The library's form.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub fn noise(&self) -> Result<LandmarkNoise> {
        let noise = LandmarkNoise {
            range_sigma: self.range_sigma_m,
            range_sigma_per_m: self.range_sigma_per_m,
            bearing_sigma: self.bearing_sigma_deg.to_radians(),
        };
        noise.check()?;
        Ok(noise)
    }
}
