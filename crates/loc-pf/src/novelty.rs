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

use crate::mcl::MountedScan;
use crate::sensor::beam::{BeamModel, RangeModel, reading};
use crate::{Particles, Result};
use loc_core::{Normal, Pose2, angle};
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

loc_core::settings! {
    /// Drops a beam that is, averaged over the belief, shorter than expected with more than a given
    /// probability (K3): something that is not in the map blocks it.
    ///
    /// A beam of range d is shorter than expected with `P(d < d* + e)`, e of `N(0, sigma_hit^2)`,
    /// with d* the range expected by the map; with 1 where no return is expected. Beams without a
    /// return are never dropped. It keeps the beams that are needed:
    ///
    /// * with a wide belief (global localization) a beam is dropped only where it is too short
    /// nearly   everywhere in the belief; * where more than `max_dropped` of the beams are too
    /// short, the belief is wrong rather than   the room crowded, and all are kept; * beams that
    /// are too long are always kept; they are the evidence for a wrong pose; * in a room as mapped
    /// a beam has to be too short by 2.3 `sigma_hit` at all poses, which is rare   by noise and by
    /// smaller errors of the belief.
    ///
    /// A few rays are cast for a beam that is kept, one for each pose of the sample for a dropped
    /// one.
    #[derive(Copy)]
    pub struct DistanceFilter {
        /// The probability from which a beam is dropped.
        pub threshold: f64 = 0.99 => probability;
        /// Standard deviation of what measures the obstacle of the map \[m\].
        pub sigma_hit: f64 = 0.2 => positive;
        /// The largest share of the beams that is dropped.
        pub max_dropped: f64 = 0.8 => probability;
    }
}

impl DistanceFilter {
    /// Which of the beams numbered `beams` to keep. Without a sample, all of them.
    ///
    /// # Errors
    /// Those of [`check`](Self::check).
    pub fn keep(
        &self,
        caster: &RayCaster,
        sample: &BeliefSample,
        mounted: &MountedScan<'_>,
        beams: &[usize],
    ) -> Result<Kept> {
        self.check()?;
        let mut suspects = suspects(mounted, beams);
        let frame = caster.frame();
        // Pose by pose: the first one explains most beams.
        for (pose, weight) in sample.poses().iter().zip(sample.weights()) {
            let laser = *pose * mounted.mounting;
            let (sin, cos) = laser.theta.sin_cos();
            let (start, [cos, sin]) =
                (frame.to_cells(&laser.position()), frame.turn_to_grid([cos, sin]));
            suspects.retain_mut(|suspect| {
                let [x, y] = suspect.direction;
                let along = [cos * x - sin * y, sin * x + cos * y];
                let far = (suspect.range + FAR * self.sigma_hit) / frame.resolution();
                let length = caster.cast_in_cells([start.x, start.y], along, far);
                let expected = length.map(|length| length * frame.resolution());
                suspect.not_short += weight * self.not_short(expected, suspect.range);
                suspect.not_short < 1.0 - self.threshold
            });
        }
        let mut is_novel = vec![false; beams.len()];
        if !sample.poses().is_empty() {
            suspects.iter().for_each(|suspect| is_novel[suspect.index] = true);
        }
        Ok(without(beams, &is_novel, self.max_dropped))
    }

    /// The probability that a range is not shorter than the expected one, `None` for one that is
    /// farther away than matters.
    fn not_short(&self, expected: Option<f64>, range: f64) -> f64 {
        let deviation = |expected| (range - expected) / self.sigma_hit;
        expected.map_or(0.0, |expected| Normal::STANDARD.cdf(deviation(expected)))
    }
}

/// Obstacles farther than this behind the measured range count the same \[sigma_hit\].
const FAR: f64 = 8.0;

/// A beam not explained by any pose so far.
struct Suspect {
    /// Its index in the list of beams.
    index: usize,
    /// Its direction in the laser's frame, a unit vector.
    direction: [f64; 2],
    range: f64,
    /// The probability so far that it is not too short.
    not_short: f64,
}

/// The beams with a return.
fn suspects(mounted: &MountedScan<'_>, beams: &[usize]) -> Vec<Suspect> {
    let scan = mounted.scan;
    let suspect = |(index, &beam): (usize, &usize)| {
        let range = reading(scan, beam, scan.range_max).filter(|range| range.is_finite())?;
        let (sin, cos) = scan.angle(beam).sin_cos();
        Some(Suspect { index, direction: [cos, sin], range, not_short: 0.0 })
    };
    beams.iter().enumerate().filter_map(suspect).collect()
}

loc_core::settings! {
    /// Drops a beam after which the belief would be less certain than before (K3): its entropy `H =
    /// -integral b ln b` rises.
    ///
    /// A beam that fits the belief sharpens it. One that hits a person moves weight to the edge of
    /// the belief, or to poses that were nearly excluded. So does a beam that is evidence for the
    /// robot being elsewhere: with this filter alone a kidnapped robot stays lost. Where more than
    /// `max_dropped` of the beams raise the entropy, all are kept.
    ///
    /// The density before the beam is the Gaussian with the mean and covariance of the sample; the
    /// change by the beam is summed over the sample.
    #[derive(Copy)]
    pub struct EntropyFilter {
        /// A rise up to this is accepted \[nat\]: with a few poses the entropies are uncertain.
        pub tolerance: f64 = 0.01 => non_negative;
        /// The largest share of the beams that is dropped.
        pub max_dropped: f64 = 0.8 => probability;
    }
}

impl EntropyFilter {
    /// Which of the beams numbered `beams` to keep, including those without information. `rating`
    /// is the logarithm of the likelihood of a beam, as [`by_field`] or
    /// [`by_casting`] give it.
    ///
    /// # Errors
    /// Those of [`check`](Self::check).
    pub fn keep(
        &self,
        rating: impl Fn(Point2<f64>, [f64; 2], f64) -> f64,
        sample: &BeliefSample,
        mounted: &MountedScan<'_>,
        beams: &[usize],
    ) -> Result<Kept> {
        self.check()?;
        let mounting = mounted.mounting;
        let lasers: Vec<(Point2<f64>, [f64; 2])> = sample
            .poses()
            .iter()
            .map(|pose| {
                let laser = *pose * mounting;
                let (sin, cos) = laser.theta.sin_cos();
                (laser.position(), [cos, sin])
            })
            .collect();
        let prior = sample.log_densities();
        let mut ratings = vec![0.0; lasers.len()];
        let mut raises = |beam: usize| {
            let max_range = mounted.scan.range_max;
            let Some(range) = reading(mounted.scan, beam, max_range) else { return false };
            let (y, x) = mounted.scan.angle(beam).sin_cos();
            for (rated, (laser, [cos, sin])) in ratings.iter_mut().zip(&lasers) {
                *rated = rating(*laser, [cos * x - sin * y, sin * x + cos * y], range);
            }
            change(&prior, sample.weights(), &ratings) > self.tolerance
        };
        let is_novel: Vec<bool> = beams.iter().map(|&beam| raises(beam)).collect();
        Ok(without(beams, &is_novel, self.max_dropped))
    }
}

/// How much the entropy of a belief b rises by a measurement of likelihood p. After it the belief
/// is `b p / Z`, so that its entropy is the mean of `ln Z - ln b - ln p` over the new weights
/// `w p / Z`; before, that of `-ln b` over w.
// ANCHOR: entropy
fn change(prior: &[f64], weights: &[f64], ratings: &[f64]) -> f64 {
    let largest = ratings.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !largest.is_finite() {
        return 0.0;
    }
    let (mut total, mut before, mut after) = (0.0, 0.0, 0.0);
    for ((log_density, weight), rating) in prior.iter().zip(weights).zip(ratings) {
        let rating = rating - largest;
        let new = weight * rating.exp();
        total += new;
        before -= weight * log_density;
        // A weight of 0 does not count, even with a rating of -inf.
        after -= if new > 0.0 { new * (log_density + rating) } else { 0.0 };
    }
    after / total + total.ln() - before
}
// ANCHOR_END: entropy
