//! Settings and outcomes of EKF-SLAM.

use crate::association::{AssociationSettings, Associator};
use crate::{Gate, Result};
use loc_core::error::{finite, in_range, non_negative, positive};
use loc_core::motion::{Integration, VelocityNoise};
use loc_core::{Gaussian, Pose2};
use loc_sensors::landmark_camera::LandmarkNoise;

/// Whether the association of observations with landmarks is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Identities {
    /// Known: observations carry the numbers of their landmarks (I2, I3).
    #[default]
    Known,
    /// Unknown: the numbers are ignored, the filter associates observations itself (I4).
    Unknown,
}

/// Where the models are linearised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Jacobians {
    /// At the current estimate, with the errors of all positions counted as they turn with the
    /// heading: the invariant filter (Barrau and Bonnabel 2015; Zhang et al. 2017). The
    /// absolute heading stays unobservable, as it should, and large heading errors do no harm.
    #[default]
    Invariant,
    /// At the current estimate, as in the textbook. A filter that linearises the same landmark in
    /// several places gains false information on the absolute heading, which is not observable.
    Current,
    /// At the first estimate of each pose and landmark (Huang, Mourikis and Roumeliotis 2008),
    /// which keeps the unobservable directions, and is as good as the first estimates are.
    First,
}

/// How landmarks are confirmed, merged and removed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct MapSettings {
    /// The map takes no more landmarks than this; its covariance has twice the square of it in
    /// numbers.
    pub max_landmarks: usize,
    /// A landmark is provisional until its score reaches this. It begins with 1, an observation
    /// adds 1, one that contradicts it takes its cost away; a landmark whose score is no longer above 0
    /// is removed.
    pub confirm_score: f64,
    /// What is taken from the score by an observation that contradicts the landmark; 0 where numbers
    /// are never misread, so that no numbered landmark is removed.
    pub contradiction_cost: f64,
    /// The score grows no further than this.
    pub max_score: f64,
    /// What is taken from the score when a landmark in the middle of the view is not seen. Without
    /// numbers on landmarks only.
    pub miss_cost: f64,
    /// Two landmarks become one where that is so many times likelier than that they are two.
    /// Without numbers on landmarks only.
    pub merge_ratio: f64,
    /// An observation that fits no landmark is a new one where right observations of the known ones lie
    /// that far out with a probability of less than 1 minus this.
    pub new_landmark_probability: f64,
    /// Of one moment a landmark has one observation, so that a second one beside it is of something
    /// new; unless it was seen twice, which is assumed where two observations of one landmark lie that
    /// far apart with a probability of more than 1 minus this.
    pub distinct_probability: f64,
}

impl Default for MapSettings {
    fn default() -> Self {
        MapSettings {
            max_landmarks: 3000,
            confirm_score: 3.0,
            contradiction_cost: 1.0,
            max_score: 10.0,
            miss_cost: 0.2,
            merge_ratio: 100.0,
            new_landmark_probability: 0.9999,
            distinct_probability: 0.9,
        }
    }
}

/// Settings of EKF-SLAM, with defaults for a small indoor robot.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct SlamSettings {
    /// Rule that turns velocities into poses.
    pub integration: Integration,
    /// How far odometry may be off.
    pub motion_noise: VelocityNoise,
    /// How far observations may be off.
    pub observation_noise: LandmarkNoise,
    /// Share of the variance of observations that those of one moment have in common, below 1: the
    /// error of a scale that is off, or of a stamp that is late in a turn. Observations are then compared
    /// with each other more sharply than with the pose.
    pub common_share: f64,
    /// How long that error lasts \[s\]: after so much time 1/e of it is left.
    pub common_time: f64,
    /// The camera's pose on the robot, `base_from_camera`.
    pub mounting: Pose2,
    /// Whether the association of observations is known.
    pub identities: Identities,
    /// Share of right observations of a landmark that the gate lets pass, 1 for no gate.
    pub gate_probability: f64,
    /// The association of observations without known numbers.
    pub association: AssociationSettings,
    /// Where the models are linearised.
    pub jacobians: Jacobians,
    /// How landmarks are confirmed, merged and removed.
    pub map: MapSettings,
    /// If given, the filter updates only the landmarks within this radius \[m\], and applies the
    /// pending updates of the others when the robot leaves (Guivant and Nebot 2001): the same result, at a cost that follows the landmarks nearby. Best at twice the camera's range.
    pub submap_radius: Option<f64>,
}

impl Default for SlamSettings {
    fn default() -> Self {
        SlamSettings {
            integration: Integration::ExactArc,
            motion_noise: VelocityNoise::default(),
            observation_noise: LandmarkNoise::default(),
            common_share: 0.0,
            common_time: 10.0,
            mounting: Pose2::IDENTITY,
            identities: Identities::Known,
            gate_probability: 0.999,
            association: AssociationSettings::default(),
            jacobians: Jacobians::Invariant,
            map: MapSettings::default(),
            submap_radius: None,
        }
    }
}

impl SlamSettings {
    /// Checks every value.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for noise without a sigma, probabilities outside (0, 1],
    /// and values that are negative or not finite.
    pub fn check(&self) -> Result<()> {
        self.observation_noise.check()?;
        positive("sigma of the range [m]", self.observation_noise.range_sigma)?;
        positive("sigma of the bearing [rad]", self.observation_noise.bearing_sigma)?;
        self.motion_noise.check()?;
        in_range("common share of the variance", "in [0, 1)", self.common_share, |share| {
            (0.0..1.0).contains(&share)
        })?;
        positive("time of the common error [s]", self.common_time)?;
        for value in [self.mounting.x, self.mounting.y, self.mounting.theta] {
            finite("mounting of the camera [m, m, rad]", value)?;
        }
        let map = &self.map;
        in_range(
            "most score of a landmark",
            "at least the score to confirm",
            map.max_score,
            |s| s.is_finite() && s >= map.confirm_score,
        )?;
        positive("score that confirms a landmark", map.confirm_score)?;
        non_negative("cost of not seeing a landmark", map.miss_cost)?;
        non_negative("cost of contradicting a landmark", map.contradiction_cost)?;
        self.submap_radius.map_or(Ok(0.0), |radius| positive("radius of a submap [m]", radius))?;
        if self.submap_radius.is_some() && self.jacobians == Jacobians::Invariant {
            return Err(crate::Error::SubmapTurns);
        }
        self.new_landmark_gate()?;
        self.distinct_gate()?;
        Gate::probability(self.gate_probability)?;
        Associator::new(self.association)?;
        Associator::new(self.merging())?;
        Ok(())
    }

    /// How landmarks are found that are in the map twice.
    pub(super) fn merging(&self) -> AssociationSettings {
        let rule = crate::association::Rule::JointCompatibility;
        AssociationSettings { rule, min_ratio: self.map.merge_ratio, ..self.association }
    }

    /// The NIS beyond which an observation is one of something new.
    pub(super) fn new_landmark_gate(&self) -> Result<f64> {
        Ok(Gate::probability(self.map.new_landmark_probability)?.threshold(2))
    }

    /// The NIS up to which two observations of one moment may be of one landmark.
    pub(super) fn distinct_gate(&self) -> Result<f64> {
        Ok(Gate::probability(self.map.distinct_probability)?.threshold(2))
    }
}

/// A landmark of the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapLandmark {
    /// Its number.
    pub id: u32,
    /// Its position \[m\].
    pub position: Gaussian<2>,
    /// How many observations it was corrected with, the first one included.
    pub observations: u32,
    /// Whether its score has reached the confirmation; a provisional landmark may be removed again.
    pub confirmed: bool,
}
