//! The weighting of nav2_amcl's `likelihood_field`.

use super::{Likelihood, add};
use crate::Poses;
use loc_maps::LikelihoodField;
use loc_maps::likelihood_field::{Endpoints, LikelihoodTable};

/// A scan before a likelihood field, weighted as nav2_amcl does: `weight *= 1 + sum pz^3`, with
/// the sum over the beams and pz the likelihood of one, for which the field must be one of
/// [`unnormalised`](loc_maps::likelihood_field::LikelihoodFieldSettings::unnormalised) settings.
///
/// It is no probability: a beam that contradicts a pose costs next to nothing, a cloud narrows
/// slowly whatever the number of beams. Use it to compare with nav2_amcl, or to take over a
/// parameter file that was tuned with it; [`FieldLikelihood`](super::FieldLikelihood) is sharper.
///
/// The pz come from the codes of the field, so each is off by half a step at most (0.8 % with
/// nav2_amcl's defaults, its cube by 2.3 %); over the beams of a scan this averages out.
#[derive(Debug, Clone)]
pub struct SumOfCubes<'a> {
    field: &'a LikelihoodField,
    endpoints: &'a Endpoints,
    cubes: LikelihoodTable,
}

impl<'a> SumOfCubes<'a> {
    /// A scan whose beams end at `endpoints`, in the frame of the robot.
    pub fn new(field: &'a LikelihoodField, endpoints: &'a Endpoints) -> Self {
        let cubes = field.table(|log_likelihood| (3.0 * log_likelihood).exp());
        SumOfCubes { field, endpoints, cubes }
    }
}

impl Likelihood for SumOfCubes<'_> {
    fn rate(&self, poses: Poses<'_>, log_weights: &mut [f64]) {
        add(poses, log_weights, |poses, out| {
            self.field.sums(&self.cubes, poses, self.endpoints, out);
            out.iter_mut().for_each(|sum| *sum = sum.ln_1p());
        });
    }
}
