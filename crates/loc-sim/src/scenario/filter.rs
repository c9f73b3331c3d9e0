//! What the filters are told, in the units of configuration files.

use crate::Result;
use loc_core::Pose2;
use loc_core::error::{non_negative, positive};
use loc_core::motion::{Integration, VelocityNoise};
use loc_filters::landmark::LandmarkSettings;
use loc_sensors::landmark_camera::LandmarkNoise;
use serde::Deserialize;

/// Settings of the methods. What is left out follows the simulated sensors, or the defaults.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FilterConfig {
    /// Rule of dead reckoning: `euler`, `midpoint` or `exact-arc`.
    pub integration: Integration,
    /// How far odometry is believed to be off.
    pub odometry: Option<OdometryNoiseConfig>,
    /// How far sightings are believed to be off.
    pub camera: Option<SightNoiseConfig>,
    /// Share of right sightings that the gate lets pass, 1 for no gate.
    pub gate_probability: Option<f64>,
    /// How late an input may come.
    pub horizon_s: Option<f64>,
}

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
pub struct SightNoiseConfig {
    /// Of the distance, at the camera.
    pub range_sigma_m: f64,
    /// Its growth with the distance.
    #[serde(default)]
    pub range_sigma_per_m: f64,
    /// Of the direction.
    pub bearing_sigma_deg: f64,
}

/// Where a robot starts, and how well that is known.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StartConfig {
    /// Position.
    pub x_m: f64,
    /// Position.
    pub y_m: f64,
    /// Heading, counter-clockwise.
    pub heading_deg: f64,
    /// Standard deviation of x and of y; the filters start at a pose drawn from it.
    pub position_sigma_m: f64,
    /// Standard deviation of the heading.
    pub heading_sigma_deg: f64,
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

impl SightNoiseConfig {
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

impl StartConfig {
    /// The true start pose.
    pub fn pose(&self) -> Pose2 {
        Pose2::new(self.x_m, self.y_m, self.heading_deg.to_radians())
    }

    /// Standard deviations of (x, y, heading) \[m, m, rad\].
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for negative ones.
    pub fn sigmas(&self) -> Result<[f64; 3]> {
        let position = non_negative("position_sigma_m", self.position_sigma_m)?;
        let heading = non_negative("heading_sigma_deg", self.heading_sigma_deg)?;
        Ok([position, position, heading.to_radians()])
    }
}

impl FilterConfig {
    /// Settings with what this section says put over `settings`.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub(super) fn apply(&self, mut settings: LandmarkSettings) -> Result<LandmarkSettings> {
        settings.integration = self.integration;
        if let Some(noise) = &self.odometry {
            settings.motion_noise = noise.noise()?;
        }
        if let Some(noise) = &self.camera {
            settings.sight_noise = noise.noise()?;
        }
        if let Some(probability) = self.gate_probability {
            settings.gate_probability = positive("filter.gate_probability", probability)?;
        }
        if let Some(horizon) = self.horizon_s {
            settings.horizon = non_negative("filter.horizon_s", horizon)?;
        }
        Ok(settings)
    }
}
