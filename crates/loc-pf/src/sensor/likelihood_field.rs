//! Scans rated by the likelihood field (M7).
//!
//! A beam is likely where it ends near an obstacle of the map. [`FieldLikelihood`] multiplies the
//! likelihoods of all beams, as the textbook does (Thrun, Burgard and Fox, "Probabilistic
//! Robotics", 2005, table 6.3); [`BeamSkip`] leaves out beforehand the beams that end on things
//! that are not in the map; [`SumOfCubes`] is the weighting of nav2_amcl, for comparison.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_maps::grid::{Cell, GridFrame, OccupancyGrid};
//! use loc_maps::likelihood_field::{Endpoints, LikelihoodField, LikelihoodFieldSettings};
//! use loc_pf::sensor::{BeamSkip, FieldLikelihood, Likelihood};
//! use loc_pf::Particles;
//! let mut grid = OccupancyGrid::filled(GridFrame::new(100, 100, 0.05, Pose2::IDENTITY)?, 0);
//! (0..100).try_for_each(|row| grid.set(Cell::new(80, row), 100))?;
//! let field = LikelihoodField::new(&grid, &LikelihoodFieldSettings::nav2())?;
//! // Three beams end on the wall 2 m ahead, and one on a person.
//! let scan = Endpoints::from_scan(&[-0.1, 0.0, 0.1, 0.2], &[2.0, 2.0, 2.0, 0.7]);
//! let poses = [Pose2::new(2.0, 2.5, 0.0), Pose2::new(1.9, 2.5, 0.0)];
//! let mut particles = Particles::from_poses(poses);
//! let scan = BeamSkip::default().apply(&field, particles.poses(), &scan);
//! assert_eq!(scan.len(), 3);
//! let (poses, log_weights) = particles.poses_and_log_weights();
//! FieldLikelihood { field: &field, endpoints: &scan, exponent: 1.0 }.rate(poses, log_weights);
//! assert!(log_weights[0] > log_weights[1]);
//! # Ok::<(), loc_pf::Error>(())
//! ```

use super::Likelihood;
use crate::Poses;
use loc_maps::LikelihoodField;
use loc_maps::likelihood_field::{Endpoints, LikelihoodTable};

/// Poses that are rated before their weights are written: their values stay in the cache.
const GROUP: usize = 512;

/// A scan in a likelihood field: the product of the likelihoods of its beams. It is also what
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

/// Adds to each weight the result of `compute` for its pose; poses are computed in groups.
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

/// A scan in a likelihood field, weighted as nav2_amcl does: `weight *= 1 + sum pz^3`, with
/// the sum over the beams and pz the likelihood of one, for which the field must be one of
/// [`unnormalised`](loc_maps::likelihood_field::LikelihoodFieldSettings::unnormalised) settings.
///
/// It is no probability: a beam that contradicts a pose costs almost nothing, and the particles
/// converge slowly with any number of beams. Use it to compare with nav2_amcl, or to use a
/// parameter file that was tuned with it; [`FieldLikelihood`] is sharper.
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

/// Maximum number of particles that vote on a beam, evenly selected: the standard error of the
/// share is then 0.015, and the pass costs little beside the rating.
const ASKED: usize = 1024;

loc_core::settings! {
    /// Beam skipping (`do_beamskip` of nav2_amcl) and its settings; the defaults are those of
    /// nav2_amcl.
    ///
    /// A person or a parcel shortens beams; those that end some `sigma_hit` before a wall pull the
    /// estimate until they touch it. So before a scan is rated, the particles vote on each beam: it
    /// is kept if enough of them see it end near an obstacle of the map. (Beams that end far from
    /// everything need no skipping here: they cost all poses the same.)
    ///
    /// This is valid only while the particles are near the true pose. When they are not, almost all
    /// beams disagree, and they are the evidence for that: where more than `error_threshold` of
    /// them would be skipped, or the particles are wider than `distance`, all are kept. In a static
    /// world the beams of a tracked robot agree with the particles, and nearly all are kept too.
    #[derive(Copy)]
    pub struct BeamSkip {
        /// How far from the nearest obstacle a beam may end to agree with a particle \[m\]
        /// (`beam_skip_distance`); less than the field's `max_distance`, or no beam is skipped.
        pub distance: f64 = 0.5 => positive;
        /// A beam is kept if more than this share of the particles agrees with it
        /// (`beam_skip_threshold`).
        pub threshold: f64 = 0.3 => probability;
        /// All beams are kept if at least this share would be skipped
        /// (`beam_skip_error_threshold`).
        pub error_threshold: f64 = 0.9 => probability;
    }
}

impl BeamSkip {
    /// For each beam of a scan whether it is kept. The result depends on the order of the poses
    /// where there are more than 1024, not on threads.
    pub fn keep(
        &self,
        field: &LikelihoodField,
        poses: Poses<'_>,
        endpoints: &Endpoints,
    ) -> Vec<bool> {
        let step = poses.len().div_ceil(ASKED).max(1);
        let [x, y, theta] = [poses.x, poses.y, poses.theta]
            .map(|all| all.iter().copied().step_by(step).collect::<Vec<f64>>());
        if x.is_empty() || spread(&x, &y) > self.distance {
            return vec![true; endpoints.len()];
        }
        let min = self.threshold * x.len() as f64;
        let hits = field.hits(self.distance, [&x, &y, &theta], endpoints);
        let keep: Vec<bool> = hits.into_iter().map(|hits| f64::from(hits) > min).collect();
        let skipped = keep.iter().filter(|keep| !**keep).count();
        if skipped as f64 >= self.error_threshold * keep.len() as f64 {
            return vec![true; endpoints.len()];
        }
        keep
    }

    /// The beams that are kept.
    #[must_use]
    pub fn apply(
        &self,
        field: &LikelihoodField,
        poses: Poses<'_>,
        endpoints: &Endpoints,
    ) -> Endpoints {
        endpoints.selected(&self.keep(field, poses, endpoints))
    }
}

/// Root mean square distance from the mean \[m\].
fn spread(x: &[f64], y: &[f64]) -> f64 {
    let variance = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        squares / values.len() as f64
    };
    (variance(x) + variance(y)).sqrt()
}
