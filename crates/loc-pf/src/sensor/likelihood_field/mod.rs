//! Scans rated by the likelihood field (M7).
//!
//! A beam is likely where it ends near an obstacle of the map. [`FieldLikelihood`] multiplies the
//! likelihoods of all beams, as the textbook does (Thrun, Burgard and Fox, "Probabilistic
//! Robotics", 2005, table 6.3); [`BeamSkip`] leaves out beforehand the beams that end on things
//! which the map does not have; [`SumOfCubes`] is the weighting of nav2_amcl, for comparison.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_maps::grid::{Cell, GridFrame, OccupancyGrid};
//! use loc_maps::likelihood_field::{Endpoints, LikelihoodField, LikelihoodFieldSettings};
//! use loc_pf::sensor::{BeamSkip, FieldLikelihood, Likelihood};
//! use loc_pf::Particles;
//! let mut grid = OccupancyGrid::filled(GridFrame::new(100, 100, 0.05, Pose2::IDENTITY)?, 0);
//! (0..100).try_for_each(|row| grid.set(Cell::new(80, row), 100))?;
//! let field = LikelihoodField::new(&grid, &LikelihoodFieldSettings::default())?;
//! // Three beams end on the wall 2 m ahead, and one on a person.
//! let scan = Endpoints::from_scan(&[-0.1, 0.0, 0.1, 0.2], &[2.0, 2.0, 2.0, 0.7]);
//! let poses = [Pose2::new(2.0, 2.5, 0.0), Pose2::new(1.9, 2.5, 0.0)];
//! let mut cloud = Particles::from_poses(poses);
//! let scan = BeamSkip::default().apply(&field, cloud.poses(), &scan);
//! assert_eq!(scan.len(), 3);
//! let (poses, log_weights) = cloud.poses_and_log_weights();
//! FieldLikelihood { field: &field, endpoints: &scan, exponent: 1.0 }.rate(poses, log_weights);
//! assert!(log_weights[0] > log_weights[1]);
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod beam_skip;
mod sum_of_cubes;

pub use beam_skip::BeamSkip;
pub use sum_of_cubes::SumOfCubes;

use super::Likelihood;
use crate::Poses;
use loc_maps::LikelihoodField;
use loc_maps::likelihood_field::Endpoints;

/// Poses that are rated before their weights are touched: their figures stay in fast memory.
const GROUP: usize = 512;

/// A scan before a likelihood field: the product of the likelihoods of its beams. It is also what
/// nav2_amcl computes as `likelihood_field_prob`, on a field of
/// [`unnormalised`](loc_maps::likelihood_field::LikelihoodFieldSettings::unnormalised) settings.
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

// ANCHOR: field
impl Likelihood for FieldLikelihood<'_> {
    fn rate(&self, poses: Poses<'_>, log_weights: &mut [f64]) {
        add(poses, log_weights, |poses, out| {
            self.field.log_likelihoods(poses, self.endpoints, out);
            out.iter_mut().for_each(|log_likelihood| *log_likelihood *= self.exponent);
        });
    }
}
// ANCHOR_END: field

/// Adds to each weight what `compute` says of its pose; poses are computed in groups.
fn add(
    Poses { x, y, theta }: Poses<'_>,
    log_weights: &mut [f64],
    compute: impl Fn([&[f64]; 3], &mut [f64]),
) {
    let poses = x.chunks(GROUP).zip(y.chunks(GROUP)).zip(theta.chunks(GROUP));
    let mut out = [0.0; GROUP];
    for (((x, y), theta), weights) in poses.zip(log_weights.chunks_mut(GROUP)) {
        let out = &mut out[..weights.len()];
        compute([x, y, theta], out);
        weights.iter_mut().zip(out).for_each(|(weight, added)| *weight += *added);
    }
}
