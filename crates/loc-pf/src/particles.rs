//! The belief of a particle filter: a set of poses, each with a weight.
//!
//! Coordinates are stored separately (structure of arrays), so that loops over the particles run
//! through memory in order and take several particles at once. Weights are kept as logarithms:
//! the product of 720 likelihoods is far below the smallest number, its logarithm is not.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_pf::Particles;
//! let mut particles = Particles::from_poses([Pose2::IDENTITY, Pose2::new(1.0, 0.0, 0.0)]);
//! particles.log_weights_mut()[1] = -4000.0;
//! particles.normalize();
//! assert_eq!(particles.weight(0), 1.0);
//! assert!((particles.effective_sample_size() - 1.0).abs() < 1e-9);
//! ```

use crate::Workers;
use crate::log_weights;
use loc_core::{Gaussian, Pose2};
use rand::Rng;

/// Weighted poses, structure of arrays: 32 bytes a particle.
///
/// Headings lie in (-pi, pi]; log weights are finite or -inf, never NaN.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Particles {
    x: Vec<f64>,
    y: Vec<f64>,
    theta: Vec<f64>,
    log_weight: Vec<f64>,
}

/// The poses of some particles, to read.
#[derive(Debug, Clone, Copy)]
pub struct Poses<'a> {
    /// Positions \[m\].
    pub x: &'a [f64],
    /// Positions \[m\].
    pub y: &'a [f64],
    /// Headings \[rad\], in (-pi, pi].
    pub theta: &'a [f64],
}

/// The poses of some particles, to change.
#[derive(Debug)]
pub struct PosesMut<'a> {
    /// Positions \[m\].
    pub x: &'a mut [f64],
    /// Positions \[m\].
    pub y: &'a mut [f64],
    /// Headings \[rad\], in (-pi, pi].
    pub theta: &'a mut [f64],
}

impl<'a> Poses<'a> {
    /// Number of poses.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// The poses in parts of `size`, which must not be 0; the last part may be smaller.
    pub(crate) fn chunks(self, size: usize) -> impl ExactSizeIterator<Item = Poses<'a>> {
        let parts = self.x.chunks(size).zip(self.y.chunks(size)).zip(self.theta.chunks(size));
        parts.map(|((x, y), theta)| Poses { x, y, theta })
    }

    /// One pose.
    ///
    /// # Panics
    /// Where there is no pose `index`.
    pub fn at(&self, index: usize) -> Pose2 {
        Pose2 { x: self.x[index], y: self.y[index], theta: self.theta[index] }
    }

    /// The poses one by one.
    pub fn iter(self) -> impl Iterator<Item = Pose2> + Clone + 'a {
        let coordinates = self.x.iter().zip(self.y).zip(self.theta);
        coordinates.map(|((&x, &y), &theta)| Pose2 { x, y, theta })
    }
}

impl<'a> PosesMut<'a> {
    /// The poses in parts of `size`, which must not be 0; the last part may be smaller.
    pub(crate) fn chunks(self, size: usize) -> impl ExactSizeIterator<Item = PosesMut<'a>> {
        let PosesMut { x, y, theta } = self;
        let parts = x.chunks_mut(size).zip(y.chunks_mut(size)).zip(theta.chunks_mut(size));
        parts.map(|((x, y), theta)| PosesMut { x, y, theta })
    }

    /// Takes the poses of `other` at `indices`, of which there are as many.
    pub(crate) fn copy_selected(self, other: Poses<'_>, indices: &[u32]) {
        let pick = |target: &mut [f64], from: &[f64]| {
            for (target, &index) in target.iter_mut().zip(indices) {
                *target = from[index as usize];
            }
        };
        pick(self.x, other.x);
        pick(self.y, other.y);
        pick(self.theta, other.theta);
    }
}

impl Particles {
    /// Every k-th particle with its weight, at most `max` of them.
    pub fn thinned(&self, max: usize) -> Vec<(Pose2, f64)> {
        let step = self.len().div_ceil(max.max(1)).max(1);
        self.poses().iter().zip(self.weights()).step_by(step).collect()
    }

    /// A cloud without particles.
    pub fn new() -> Self {
        Particles::default()
    }

    /// Particles at the given poses, all of the same weight.
    pub fn from_poses(poses: impl IntoIterator<Item = Pose2>) -> Self {
        let mut particles = Particles::new();
        for pose in poses {
            particles.push(pose, 0.0);
        }
        particles.set_equal_weights();
        particles
    }

    /// `count` particles drawn from a belief about the pose.
    pub fn from_gaussian<R: Rng + ?Sized>(belief: &Gaussian<3>, count: usize, rng: &mut R) -> Self {
        let draw = |_| {
            let [x, y, theta] = belief.sample(rng).into();
            Pose2::new(x, y, theta)
        };
        Particles::from_poses((0..count).map(draw))
    }

    /// Adds a particle.
    pub fn push(&mut self, pose: Pose2, log_weight: f64) {
        self.x.push(pose.x);
        self.y.push(pose.y);
        self.theta.push(pose.theta);
        self.log_weight.push(log_weight);
    }

    /// Removes all particles; their memory is kept.
    pub fn clear(&mut self) {
        for column in [&mut self.x, &mut self.y, &mut self.theta, &mut self.log_weight] {
            column.clear();
        }
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// All poses, to read.
    pub fn poses(&self) -> Poses<'_> {
        Poses { x: &self.x, y: &self.y, theta: &self.theta }
    }

    /// All poses, to change.
    pub fn poses_mut(&mut self) -> PosesMut<'_> {
        PosesMut { x: &mut self.x, y: &mut self.y, theta: &mut self.theta }
    }

    /// The pose of one particle.
    ///
    /// # Panics
    /// Where there is no particle `index`.
    pub fn pose(&self, index: usize) -> Pose2 {
        Pose2 { x: self.x[index], y: self.y[index], theta: self.theta[index] }
    }

    /// Sets the pose of one particle.
    ///
    /// # Panics
    /// Where there is no particle `index`.
    pub fn set_pose(&mut self, index: usize, pose: Pose2) {
        (self.x[index], self.y[index], self.theta[index]) = (pose.x, pose.y, pose.theta);
    }

    /// Replaces particles evenly spread over the set by `others`, which get the mean weight; at
    /// most all of them.
    pub fn replace_evenly(&mut self, others: &[Pose2]) {
        let equal = -(self.len() as f64).ln();
        let count = others.len().min(self.len());
        for (number, stranger) in others.iter().take(count).enumerate() {
            let index = number * self.len() / count;
            self.set_pose(index, *stranger);
            self.log_weight[index] = equal;
        }
        if count > 0 {
            self.normalize();
        }
    }

    /// Checks that there are as many weights as poses, poses are finite and weights not NaN, as
    /// for particles read from a file.
    ///
    /// # Errors
    /// [`loc_core::Error::Length`] and [`loc_core::Error::OutOfRange`].
    pub fn check(&self) -> crate::Result<()> {
        use loc_core::error::{finite, in_range};
        let found = self.log_weight.len();
        if [self.x.len(), self.y.len(), self.theta.len()] != [found; 3] {
            let (what, expected) = ("weights of particles", "as many as poses");
            return Err(loc_core::Error::Length { what, expected, found }.into());
        }
        for (pose, weight) in self.poses().iter().zip(&self.log_weight) {
            finite("x of a particle [m]", pose.x)?;
            finite("y of a particle [m]", pose.y)?;
            finite("heading of a particle [rad]", pose.theta)?;
            let allowed = |weight: f64| weight < f64::INFINITY;
            in_range("log weight of a particle", "a number or -inf", *weight, allowed)?;
        }
        Ok(())
    }

    /// Logarithms of the weights.
    pub fn log_weights(&self) -> &[f64] {
        &self.log_weight
    }

    /// Logarithms of the weights, to change.
    pub fn log_weights_mut(&mut self) -> &mut [f64] {
        &mut self.log_weight
    }

    /// Poses to read and log weights to change, at the same time.
    pub fn poses_and_log_weights(&mut self) -> (Poses<'_>, &mut [f64]) {
        (Poses { x: &self.x, y: &self.y, theta: &self.theta }, &mut self.log_weight)
    }

    /// Poses and log weights to change, at the same time.
    pub(crate) fn columns_mut(&mut self) -> (PosesMut<'_>, &mut [f64]) {
        let poses = PosesMut { x: &mut self.x, y: &mut self.y, theta: &mut self.theta };
        (poses, &mut self.log_weight)
    }

    /// Replaces all particles by the given poses with the given log weights, of which there are as
    /// many.
    pub(crate) fn refill(
        &mut self,
        poses: impl Iterator<Item = Pose2> + Clone,
        log_weights: impl Iterator<Item = f64>,
    ) {
        self.clear();
        self.x.extend(poses.clone().map(|pose| pose.x));
        self.y.extend(poses.clone().map(|pose| pose.y));
        self.theta.extend(poses.map(|pose| pose.theta));
        self.log_weight.extend(log_weights);
    }

    /// The weight of one particle.
    ///
    /// # Panics
    /// Where there is no particle `index`.
    pub fn weight(&self, index: usize) -> f64 {
        self.log_weight[index].exp()
    }

    /// The weights, not as logarithms.
    pub fn weights(&self) -> impl Iterator<Item = f64> + '_ {
        self.log_weight.iter().map(|weight| weight.exp())
    }

    /// Fills `relative` with all weights in units of the largest, faster than one by one from
    /// [`weights`](Particles::weights) and without underflow; NaN counts as 0. Where none is above
    /// 0 they count as equal.
    pub fn relative_weights(&self, relative: &mut Vec<f64>) {
        log_weights::relative(&Workers::one(), &self.log_weight, relative);
    }

    /// Gives every particle the weight 1 / M.
    pub fn set_equal_weights(&mut self) {
        let equal = -(self.len() as f64).ln();
        self.log_weight.fill(equal);
    }

    /// Makes the weights add up to 1 and returns the logarithm of what they added up to before:
    /// after [`weigh`](crate::ParticleFilter::weigh), the logarithm of the mean likelihood.
    ///
    /// Weights that are all 0, or infinite, become equal, and the result is -inf. A single weight
    /// that is not a number becomes 0.
    pub fn normalize(&mut self) -> f64 {
        let workers = Workers::one();
        let mass = workers.add_up(self);
        workers.divide_by(self, &mass)
    }

    /// How many particles of equal weight would carry as much information: `(sum w)^2 / sum w^2`,
    /// between 1 and M; 0 where no weight is above 0.
    pub fn effective_sample_size(&self) -> f64 {
        Workers::one().add_up(self).effective_sample_size()
    }

    /// Replaces all particles by those of `other` at `indices`, with equal weights.
    ///
    /// # Panics
    /// Where an index has no particle.
    pub fn copy_selected(&mut self, other: &Particles, indices: &[u32]) {
        self.resize(indices.len());
        self.poses_mut().copy_selected(other.poses(), indices);
    }

    /// Makes room for `count` particles of equal weights; their poses are unspecified.
    pub(crate) fn resize(&mut self, count: usize) {
        for column in [&mut self.x, &mut self.y, &mut self.theta, &mut self.log_weight] {
            column.resize(count, 0.0);
        }
        self.set_equal_weights();
    }
}
