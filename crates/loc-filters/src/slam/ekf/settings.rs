//! Settings and outcomes of EKF-SLAM.

use crate::association::AssociationSettings;
use crate::{Gate, Result, RobotSettings};
use loc_core::Gaussian;

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

loc_core::settings! {
    /// How landmarks are confirmed, merged and removed.
    #[derive(Copy)]
    pub struct MapSettings {
        /// The map takes no more landmarks than this; its covariance has twice the square of it in
        /// numbers.
        pub max_landmarks: usize = 3000 => at_least(1);
        /// A landmark is provisional until its score reaches this. It begins with 1, an observation
        /// adds 1, one that contradicts it takes its cost away; a landmark whose score is no longer
        /// above 0 is removed.
        pub confirm_score: f64 = 3.0 => positive;
        /// What is taken from the score by an observation that contradicts the landmark; 0 where
        /// numbers are never misread, so that no numbered landmark is removed.
        pub contradiction_cost: f64 = 1.0 => non_negative;
        /// What is taken from the score when a landmark in the middle of the view is not seen.
        /// Without numbers on landmarks only.
        pub miss_cost: f64 = 0.2 => non_negative;
        /// Two landmarks become one where that is so many times likelier than that they are two.
        /// Without numbers on landmarks only.
        pub merge_ratio: f64 = 100.0 => at_least(1.0);
        /// An observation that fits no landmark is a new one where right observations of the known
        /// ones lie that far out with a probability of less than 1 minus this.
        pub new_landmark_probability: f64 = 0.9999 => share;
    }
}

loc_core::settings! {
    /// Settings of EKF-SLAM, with defaults for a small indoor robot.
    #[derive(Copy)]
    pub struct SlamSettings {
        /// The robot and its sensors.
        pub robot: RobotSettings = RobotSettings::default() => check;
        /// Share of the variance of observations that those of one moment have in common, below 1:
        /// the error of a scale that is off, or of a stamp that is late in a turn. Observations are
        /// then compared with each other more sharply than with the pose.
        pub common_share: f64 = 0.0 => holds("in [0, 1)", |s| (0.0..1.0).contains(&s.common_share));
        /// How long that error lasts \[s\]: after so much time 1/e of it is left.
        pub common_time: f64 = 10.0 => positive;
        /// Whether the association of observations is known.
        pub identities: Identities = Identities::Known => any;
        /// The association of observations without known numbers.
        pub association: AssociationSettings = AssociationSettings::default() => check;
        /// Where the models are linearised.
        pub jacobians: Jacobians = Jacobians::Invariant => any;
        /// How landmarks are confirmed, merged and removed.
        pub map: MapSettings = MapSettings::default() => check;
        /// If given, the filter updates only the landmarks within this radius \[m\], and applies
        /// the pending updates of the others when the robot leaves (Guivant and Nebot 2001): the
        /// same result, at a cost that follows the landmarks nearby. Best at twice the camera's
        /// range.
        pub submap_radius: Option<f64> = None => each_positive;
    }
}

impl SlamSettings {
    /// Checks every value, and what goes together.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] with the name of the first setting that is not allowed;
    /// [`crate::Error::SubmapTurns`] for submaps in the invariant form.
    pub(super) fn gate(&self) -> Result<Gate> {
        self.check()?;
        if self.submap_radius.is_some() && self.jacobians == Jacobians::Invariant {
            return Err(crate::Error::SubmapTurns);
        }
        self.robot.gate()
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
        Ok(Gate::probability(DISTINCT_PROBABILITY)?.threshold(2))
    }
}

impl MapSettings {
    /// The score of a landmark grows no further than this.
    pub fn max_score(&self) -> f64 {
        self.confirm_score.max(10.0)
    }
}

/// Of one moment a landmark has one observation, so that a second one beside it is of something
/// new; unless it was seen twice, which is assumed where two observations of one landmark lie that
/// far apart with a probability of more than 1 minus this.
const DISTINCT_PROBABILITY: f64 = 0.9;

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
