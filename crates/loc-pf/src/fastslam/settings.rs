//! The settings of FastSLAM.

use crate::resample::{ResamplePolicy, ResampleWhen};
use crate::{Resampling, Result};
use loc_core::Pose2;
use loc_core::error::{finite, in_range, non_negative, positive};
use loc_core::motion::{Integration, VelocityNoise};
use loc_filters::association::{AssociationSettings, Associator, Rule};
use loc_filters::landmark::RangeBearingModel;
use loc_filters::slam::{Identities, MapSettings};
use loc_filters::{Gate, MeasurementModel};
use loc_sensors::landmark_camera::LandmarkNoise;
use nalgebra::{Point2, Vector2};

/// Settings of FastSLAM, with defaults for a small indoor robot.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct FastSlamSettings {
    /// Number of particles.
    pub particles: usize,
    /// Rule that turns velocities into poses.
    pub integration: Integration,
    /// Noise of the odometry.
    pub motion_noise: VelocityNoise,
    /// Noise of observations.
    pub observation_noise: LandmarkNoise,
    /// The camera's pose on the robot, `base_from_camera`.
    pub mounting: Pose2,
    /// Whether the data association is known (landmarks have numbers).
    pub identities: Identities,
    /// Share of right observations of a landmark that the gate lets pass, 1 for no gate.
    pub gate_probability: f64,
    /// Data association of landmarks without numbers, for each particle.
    pub association: AssociationSettings,
    /// Management of landmarks in the map. FastSLAM does not use `merge_ratio`.
    pub map: MapSettings,
    /// Share of observations, in (0, 1], that a particle expects to be of something new. Without
    /// numbers on landmarks only.
    pub new_share: f64,
    /// Probability, in (0, 1], that a landmark in the middle of the view is not seen. Without
    /// numbers on landmarks only.
    pub miss_share: f64,
    /// The particle set is resampled where its effective sample size falls below this share.
    pub resample_below: f64,
    /// How particles are drawn.
    pub resampling: Resampling,
    /// Number of threads; the results are the same for any.
    pub threads: usize,
}

impl Default for FastSlamSettings {
    fn default() -> Self {
        FastSlamSettings {
            particles: 200,
            integration: Integration::ExactArc,
            motion_noise: VelocityNoise::default(),
            observation_noise: LandmarkNoise::default(),
            mounting: Pose2::IDENTITY,
            identities: Identities::Known,
            gate_probability: 0.999,
            association: FastSlamSettings::ASSOCIATION,
            map: MapSettings::default(),
            new_share: 0.01,
            miss_share: 0.3,
            resample_below: 0.5,
            resampling: Resampling::default(),
            threads: 1,
        }
    }
}

impl FastSlamSettings {
    /// The textbook's association: each particle takes the likeliest landmark, at any
    /// margin. Wrong associations lower the weight of the particle later.
    pub const ASSOCIATION: AssociationSettings = AssociationSettings {
        rule: Rule::MaximumLikelihood,
        gate_probability: 0.999,
        min_ratio: 1.0,
        search_limit: 5_000,
    };

    /// Checks every value.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for noise without a sigma, probabilities outside (0, 1],
    /// and values that are negative or not finite; [`loc_core::Error::Length`] without particles.
    pub fn validate(&self) -> Result<()> {
        if self.particles == 0 {
            let (what, expected) = ("particles", "at least 1");
            return Err(loc_core::Error::Length { what, expected, found: 0 }.into());
        }
        self.observation_noise.check()?;
        positive("sigma of the range [m]", self.observation_noise.range_sigma)?;
        positive("sigma of the bearing [rad]", self.observation_noise.bearing_sigma)?;
        self.motion_noise.check()?;
        for value in [self.mounting.x, self.mounting.y, self.mounting.theta] {
            finite("mounting of the camera [m, m, rad]", value)?;
        }
        let map = &self.map;
        let allowed = |max: f64| max.is_finite() && max >= map.confirm_score;
        let expected = "at least the score to confirm";
        in_range("most score of a landmark", expected, map.max_score, allowed)?;
        positive("score that confirms a landmark", map.confirm_score)?;
        non_negative("cost of not seeing a landmark", map.miss_cost)?;
        non_negative("cost of contradicting a landmark", map.contradiction_cost)?;
        for (what, share) in [("new_share", self.new_share), ("miss_share", self.miss_share)] {
            loc_core::error::probability(what, positive(what, share)?)?;
        }
        self.policy().validate()?;
        Gate::probability(map.new_landmark_probability)?;
        Gate::probability(self.gate_probability)?;
        Associator::new(self.association)?;
        Ok(())
    }

    /// When to resample.
    pub(super) fn policy(&self) -> ResamplePolicy {
        ResamplePolicy { every: 1, when: ResampleWhen::EffectiveShareBelow(self.resample_below) }
    }

    pub(super) fn model(&self, landmark: Point2<f64>) -> RangeBearingModel {
        RangeBearingModel { landmark, mounting: self.mounting, noise: self.observation_noise }
    }

    /// Variances of distance and direction of something at a distance \[m\].
    pub(super) fn observation_variances(&self, range: f64) -> Vector2<f64> {
        self.model(Point2::origin()).noise(&Vector2::new(range, 0.0)).diagonal()
    }
}
