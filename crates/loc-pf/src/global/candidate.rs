//! What a search finds.

use loc_core::Pose2;
use loc_maps::LikelihoodField;
use loc_maps::likelihood_field::Endpoints;

/// A pose where the robot may be.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Candidate {
    /// The pose.
    pub pose: Pose2,
    /// Logarithm of the likelihood of the scan there, the sum over its beams.
    pub log_likelihood: f64,
}

impl Candidate {
    /// A pose, rated.
    pub(super) fn rate(field: &LikelihoodField, pose: Pose2, endpoints: &Endpoints) -> Self {
        Candidate { pose, log_likelihood: field.log_likelihood(pose, endpoints) }
    }
}
