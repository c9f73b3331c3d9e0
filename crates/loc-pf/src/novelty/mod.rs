//! Novelty filters: leaving out the beams that hit what is on no map (K3).
//!
//! A localizer assumes that measurements depend on the pose alone. People who walk along with a
//! robot violate that for many cycles in a row: the beams that end on them agree with some wrong
//! pose, to which the filter finally converges. Fox, Burgard and Thrun ("Markov localization for
//! mobile robots in dynamic environments", 1999) remove beams before they are used, by the present
//! belief. The [`DistanceFilter`] drops a beam that is very likely shorter than expected by the
//! map; it is for range finders, and the one to prefer. The [`EntropyFilter`] drops a beam that
//! would increase the uncertainty of the pose; it works for any sensor, but also drops the evidence
//! that the robot is elsewhere.
//!
//! Both use a [`BeliefSample`], a few poses of the particles after the motion and before weighting.
//!
//! ```
//! use loc_core::{Pose2, gaussian::pose_belief, random::stream};
//! use loc_maps::RayCaster;
//! use loc_maps::grid::{Cell, GridFrame, OccupancyGrid};
//! use loc_pf::Particles;
//! use loc_pf::mcl::MountedScan;
//! use loc_pf::novelty::{BeliefSample, DistanceFilter};
//! use loc_sensors::laser::LaserScan;
//! let mut grid = OccupancyGrid::filled(GridFrame::new(200, 200, 0.05, Pose2::IDENTITY)?, 0);
//! (0..200).try_for_each(|row| grid.set(Cell::new(160, row), 100))?;
//! let caster = RayCaster::new(&grid);
//! // The wall is 3 m ahead; a person stands before the second of the five beams.
//! let scan = LaserScan {
//!     angle_min: -0.2, angle_max: 0.2, angle_increment: 0.1,
//!     time_increment: 0.0, scan_time: 0.1, range_min: 0.1, range_max: 20.0,
//!     ranges: vec![3.06, 1.2, 3.0, 3.01, 3.06], intensities: Vec::new(),
//! };
//! let mounted = MountedScan { scan: &scan, mounting: Pose2::IDENTITY };
//! let belief = pose_belief(Pose2::new(5.0, 5.0, 0.0), [0.1, 0.1, 0.05]);
//! let particles = Particles::from_gaussian(&belief, 500, &mut stream(1, "filter"));
//! let sample = BeliefSample::of(&particles, 64);
//! let kept = DistanceFilter::default().keep(&caster, &sample, &mounted, &[0, 1, 2, 3, 4])?;
//! assert_eq!((kept.beams, kept.novel), (vec![0, 2, 3, 4], 1));
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod filters;

pub use filters::{DistanceFilter, EntropyFilter};

use crate::Particles;
use crate::sensor::beam::{BeamModel, RangeModel};
use loc_core::{Pose2, angle};
use loc_maps::{LikelihoodField, RayCaster};
use nalgebra::{Matrix3, Point2, Vector3};

/// The result of a filter for the beams of a scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Kept {
    /// Numbers of the beams to use, in the order in which they were given.
    pub beams: Vec<usize>,
    /// Number of beams that did not fit the belief; they are kept nevertheless where there are too
    /// many.
    pub novel: usize,
}

/// The beams without the novel ones, or all of them where more than a share `max` is novel: then
/// the belief is wrong.
fn without(beams: &[usize], is_novel: &[bool], max: f64) -> Kept {
    let novel = is_novel.iter().filter(|novel| **novel).count();
    let all = novel as f64 > max * beams.len() as f64;
    let pairs = beams.iter().zip(is_novel);
    let kept = pairs.filter(|(_, novel)| all || !**novel).map(|(beam, _)| *beam);
    Kept { beams: kept.collect(), novel }
}

/// A few poses that represent the particles, with weights that add up to 1.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BeliefSample {
    poses: Vec<Pose2>,
    weights: Vec<f64>,
}

impl BeliefSample {
    /// At most `count` particles, selected by their weights with `count` evenly spaced points as in
    /// low-variance resampling (M9), but without randomness. The weights must be normalised.
    ///
    /// A particle selected by several points is taken once, with the weight of all of them, so that
    /// few different poses make a small sample. Without particles the sample is empty.
    pub fn of(particles: &Particles, count: usize) -> Self {
        let mut sample = BeliefSample::default();
        let each = 1.0 / count as f64;
        let (mut passed, mut spoke) = (0.0, 0.5 * each);
        for (pose, weight) in particles.poses().iter().zip(particles.weights()) {
            passed += weight;
            let met = ((passed - spoke) / each).ceil().max(0.0);
            if met > 0.0 && spoke < 1.0 {
                sample.poses.push(pose);
                sample.weights.push(met * each);
                spoke += met * each;
            }
        }
        let total: f64 = sample.weights.iter().sum();
        sample.weights.iter_mut().for_each(|weight| *weight /= total);
        sample
    }

    /// The poses.
    pub fn poses(&self) -> &[Pose2] {
        &self.poses
    }

    /// Their weights.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Logarithms of the belief's density at the poses, but for a constant: that of the Gaussian
    /// with the sample's mean and covariance.
    fn log_densities(&self) -> Vec<f64> {
        let sum = |of: &dyn Fn(&Pose2) -> f64| -> f64 {
            self.poses.iter().zip(&self.weights).map(|(pose, weight)| weight * of(pose)).sum()
        };
        let (sin, cos) = (sum(&|pose| pose.theta.sin()), sum(&|pose| pose.theta.cos()));
        let mean = Pose2::new(sum(&|pose| pose.x), sum(&|pose| pose.y), sin.atan2(cos));
        let deviation = |pose: &Pose2| {
            let turn = angle::difference(pose.theta, mean.theta);
            Vector3::new(pose.x - mean.x, pose.y - mean.y, turn)
        };
        // A minimum width along every direction.
        let mut covariance = Matrix3::identity() * 1e-12;
        for (pose, weight) in self.poses.iter().zip(&self.weights) {
            covariance += *weight * deviation(pose) * deviation(pose).transpose();
        }
        let Some(root) = covariance.cholesky() else { return vec![0.0; self.poses.len()] };
        let density = |pose| -0.5 * deviation(pose).dot(&root.solve(&deviation(pose)));
        self.poses.iter().map(density).collect()
    }
}

/// Rates a beam by the likelihood field: how near it ends to an obstacle. Beams without a return
/// are equally likely everywhere.
///
/// The closure takes the position of the laser in the map \[m\], the direction of the beam there as
/// a unit vector, and its range \[m\], and returns the logarithm.
pub fn by_field(field: &LikelihoodField) -> impl Fn(Point2<f64>, [f64; 2], f64) -> f64 + '_ {
    move |laser, [x, y], range| {
        if !range.is_finite() {
            return 0.0;
        }
        field.log_likelihood_at(&Point2::new(laser.x + range * x, laser.y + range * y))
    }
}

/// Rates a beam by the beam model: a ray for each beam and pose. The closure is as for
/// [`by_field`].
pub fn by_casting<'a>(
    caster: &'a RayCaster,
    model: &'a BeamModel,
) -> impl Fn(Point2<f64>, [f64; 2], f64) -> f64 + 'a {
    let frame = caster.frame();
    let max_length = model.max_range() / frame.resolution();
    move |laser, direction, range| {
        let Point2 { coords } = frame.to_cells(&laser);
        let along = frame.turn_to_grid(direction);
        let length = caster.cast_in_cells([coords.x, coords.y], along, max_length);
        let expected = length.map_or(f64::INFINITY, |length| length * frame.resolution());
        model.log_density(expected, range)
    }
}
