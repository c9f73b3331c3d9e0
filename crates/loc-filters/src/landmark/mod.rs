//! Localization with landmarks whose positions are known (H2).
//!
//! Odometry predicts the pose, each observation of a landmark corrects it. [`LandmarkEkf`] is the
//! filter of the lecture page, one prediction or correction at a time; [`LandmarkLocalizer`]
//! around it takes time-stamped velocities and observations.
//!
//! ```
//! use loc_core::{Gaussian, Pose2, gaussian::pose_belief};
//! use loc_filters::landmark::{LandmarkEkf, LandmarkSettings};
//! use loc_maps::{Landmark, LandmarkMap};
//! use loc_sensors::landmark_camera::{Observed, LandmarkObservation};
//!
//! let map = LandmarkMap::new([Landmark::planar(1, 4.0, 0.0)])?;
//! let start = pose_belief(Pose2::IDENTITY, [0.5, 0.5, 0.1]);
//! let mut ekf = LandmarkEkf::new(start, LandmarkSettings::default())?;
//! let observation = LandmarkObservation { landmark: 1, sight: Observed::Range { range: 3.5 } };
//! let outcome = ekf.correct(&map, &observation)?;
//! assert!(outcome.accepted() && ekf.belief().mean.x > 0.4);
//! # Ok::<(), loc_filters::Error>(())
//! ```

mod ekf;
mod localizer;

pub use ekf::{
    BearingModel, LandmarkEkf, LandmarkFilter, LandmarkUkf, RangeBearingModel, RangeModel,
    VelocityMotion,
};
pub use localizer::LandmarkLocalizer;

use crate::{Gate, Result};
use loc_core::Pose2;
use loc_core::motion::{Integration, VelocityNoise};
use loc_sensors::landmark_camera::LandmarkNoise;

/// Settings of landmark localization, with defaults for a small indoor robot.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct LandmarkSettings {
    /// Rule that turns velocities into poses.
    pub integration: Integration,
    /// How far odometry may be off.
    pub motion_noise: VelocityNoise,
    /// How far observations may be off.
    pub observation_noise: LandmarkNoise,
    /// The camera's pose on the robot, `base_from_camera`.
    pub mounting: Pose2,
    /// Share of right observations that the gate lets pass, 1 for no gate.
    pub gate_probability: f64,
}

impl LandmarkSettings {
    /// Checks every value and computes the gate.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for noise without a sigma, probabilities outside (0, 1],
    /// or values that are negative or not finite.
    pub(crate) fn gate(&self) -> Result<Gate> {
        self.observation_noise.check()?;
        loc_core::error::positive("sigma of the range [m]", self.observation_noise.range_sigma)?;
        loc_core::error::positive(
            "sigma of the bearing [rad]",
            self.observation_noise.bearing_sigma,
        )?;
        self.motion_noise.check()?;
        for value in [self.mounting.x, self.mounting.y, self.mounting.theta] {
            loc_core::error::finite("mounting of the camera [m, m, rad]", value)?;
        }
        Gate::probability(self.gate_probability)
    }
}

impl Default for LandmarkSettings {
    fn default() -> Self {
        LandmarkSettings {
            integration: Integration::ExactArc,
            motion_noise: VelocityNoise::default(),
            observation_noise: LandmarkNoise::default(),
            mounting: Pose2::IDENTITY,
            gate_probability: 0.999,
        }
    }
}
