//! Scans rated by the likelihood field (M7).

use super::Likelihood;
use crate::Poses;
use loc_maps::LikelihoodField;
use loc_maps::likelihood_field::Endpoints;

/// A scan before a likelihood field.
#[derive(Debug, Clone, Copy)]
pub struct FieldLikelihood<'a> {
    /// The field.
    pub field: &'a LikelihoodField,
    /// Where the beams end, in the frame of the robot.
    pub endpoints: &'a Endpoints,
    /// Power to which the likelihood is raised, in (0, 1]: the beams of a scan are not independent
    /// of each other (they pass the same door, miss the same new chair).
    pub exponent: f64,
}

impl Likelihood for FieldLikelihood<'_> {
    fn rate(&self, poses: Poses<'_>, log_weights: &mut [f64]) {
        for (pose, weight) in poses.iter().zip(log_weights) {
            *weight += self.exponent * self.field.log_likelihood(pose, self.endpoints);
        }
    }
}
