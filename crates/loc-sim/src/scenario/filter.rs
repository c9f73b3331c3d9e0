//! What the filters are told, in the units of configuration files.

use super::{FastSlamConfig, FusionConfig, LandmarkMclConfig, LaterationConfig, SlamConfig};
use crate::Result;
use crate::localizer::MethodSettings;
use crate::source::{ObservationNoiseConfig, OdometryNoiseConfig};
use loc_core::error::{non_negative, positive};
use loc_core::motion::Integration;
use loc_filters::histogram::GridSettings;
use loc_filters::landmark::LandmarkSettings;
use loc_filters::line_matching::LineMatchingSettings;
use loc_pf::MclSettings;
use serde::Deserialize;

/// Settings of the methods. What is left out follows the simulated sensors, or the defaults.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FilterConfig {
    /// Rule of dead reckoning: `euler`, `midpoint` or `exact-arc`.
    pub integration: Integration,
    /// How far odometry is believed to be off.
    pub odometry: Option<OdometryNoiseConfig>,
    /// How far observations are believed to be off.
    pub camera: Option<ObservationNoiseConfig>,
    /// Share of right observations that the gate lets pass, 1 for no gate.
    pub gate_probability: Option<f64>,
    /// How late an input may come.
    pub horizon_s: Option<f64>,
    /// Settings of line matching; where left out, it knows the noise of a simulated laser.
    pub line_matching: Option<LineMatchingSettings>,
    /// Settings of the particle filter.
    pub mcl: MclSettings,
    /// Settings of the grid over the poses in a map.
    pub histogram: GridSettings,
    /// What the particle filter among landmarks is told beside.
    pub landmark_mcl: LandmarkMclConfig,
    /// What lateration is told beside.
    pub lateration: LaterationConfig,
    /// What fusion is told beside.
    pub fusion: FusionConfig,
    /// What SLAM is told beside.
    pub slam: SlamConfig,
    /// What FastSLAM is told beside, and beside what SLAM is told.
    pub fastslam: FastSlamConfig,
    /// Whether methods that can find the robot anywhere are not told where it starts.
    pub global: bool,
    /// Whether the estimates of Kalman filters are smoothed after the run as well.
    pub smooth: bool,
}

impl FilterConfig {
    /// The settings of all methods, with what this section says put over `landmark`.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`], and what [`MclSettings::validate`] says.
    pub(super) fn methods(&self, landmark: LandmarkSettings) -> Result<MethodSettings> {
        self.mcl.validate()?;
        self.histogram.validate()?;
        let line_matching = self.line_matching.unwrap_or_default();
        line_matching.check()?;
        Ok(MethodSettings {
            landmark: self.apply(landmark)?,
            mcl: self.mcl.clone(),
            histogram: self.histogram,
            landmark_mcl: self.landmark_mcl.settings()?,
            lateration: self.lateration.settings()?,
            line_matching,
            fusion: self.fusion.settings()?,
            slam: self.slam.settings()?,
            slam_own_noise: self.slam.camera.is_some(),
            fastslam: self.fastslam.settings()?,
            global: self.global,
            smooth: self.smooth,
            ..MethodSettings::default()
        })
    }

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
            settings.observation_noise = noise.noise()?;
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
