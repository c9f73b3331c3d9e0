//! Tempered (annealed) updates, by which a small particle set finds a narrow peak.
//!
//! After odometry the pose is uncertain by decimetres; a laser scan determines it to centimetres.
//! Of a few hundred particles drawn from the motion hardly one lies within the peak of such a
//! likelihood, and plain weighting leaves copies of that one. Here the likelihood p is used in
//! stages p^b with b growing from 0 to 1: after each stage the particle set is resampled, and every
//! particle makes Metropolis-Hastings steps in the space of its motion noise. The stages adapt
//! themselves: a scan with little information needs one, and the update is the plain one.
//!
//! The result is a sample of the same posterior as that of the plain filter with very many
//! particles: the steps leave the distribution of the motion invariant (Del Moral, Doucet and
//! Jasra, "Sequential Monte Carlo samplers", 2006; Cotter et al., "MCMC methods for functions",
//! 2013).
//!
//! ```
//! use loc_core::{Pose2, random::stream};
//! use loc_pf::motion::{DrivenPath, NoisyStep, PathNoise};
//! use loc_pf::{ParticleFilter, Particles, Tempering};
//! let particles = Particles::from_poses(std::iter::repeat_n(Pose2::IDENTITY, 200));
//! let mut filter = ParticleFilter::new(particles, stream(1, "filter"));
//! let mut path = DrivenPath::starting_at(Pose2::IDENTITY);
//! path.extend(Pose2::new(4.0, 0.0, 0.0));
//! // Odometry is good to 0.1 m along the path, the measurement to 1 mm.
//! let measurement = |pose: Pose2| -0.5 * ((pose.x - 4.15) / 0.001).powi(2);
//! let step = NoisyStep::new(&path, &PathNoise::default());
//! let report = Tempering::default().update(&mut filter, &step, &measurement, 200);
//! assert!(report.stages > 3);
//! assert!(filter.particles().poses().x.iter().all(|x| (x - 4.15).abs() < 0.006));
//! ```

use crate::log_weights::Mass;
use crate::resample::CumulativeWeights;
use crate::workers::PART;
use crate::{Likelihood, ParticleFilter, Particles, Poses, Resampling, Transport, Workers};
use loc_core::random::ChaCha8Rng;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Tempered updates; keeps its memory from one update to the next.
#[derive(Debug, Default)]
pub struct Tempering {
    settings: TemperingSettings,
    parts: Vec<Part>,
    spare: Vec<Part>,
    log_weights: Vec<f64>,
    /// The same after a trial share of the measurement.
    after: Vec<f64>,
    cumulative: CumulativeWeights,
    indices: Vec<u32>,
}

/// Figures of an update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TemperingReport {
    /// Number of times the particles were rated: 1 for a plain update.
    pub stages: usize,
    /// Logarithm of the mean likelihood of the measurement over the predicted particles.
    pub log_evidence: f64,
}

impl Tempering {
    /// An update with settings other than the defaults.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub fn new(settings: TemperingSettings) -> crate::Result<Self> {
        settings.check()?;
        Ok(Tempering { settings, ..Tempering::default() })
    }

    /// Moves the particles by `step` and weights them by `measurement`. Where stages resample, they
    /// draw `count` particles (low-variance resampling); otherwise their number stays.
    pub fn update(
        &mut self,
        filter: &mut ParticleFilter,
        step: &impl Transport,
        measurement: &impl Likelihood,
        count: usize,
    ) -> TemperingReport {
        let workers = &filter.workers().clone();
        self.load(workers, filter.particles());
        filter.for_each_part(&mut self.parts, |part, rng| part.draw(step, measurement, rng));
        let (mut exponent, mut stride) = (0.0, 1.0);
        let mut report = TemperingReport { stages: 1, log_evidence: 0.0 };
        loop {
            let share = if report.stages < MAX_STAGES {
                self.share_of(workers, 1.0 - exponent)
            } else {
                1.0 - exponent
            };
            exponent += share;
            report.log_evidence += self.apply(workers, share);
            if exponent >= 1.0 - 1e-9 {
                break;
            }
            self.resample(filter, count);
            let moves = self.settings.moves;
            self.walk(filter, step, measurement, (exponent, &mut stride), moves);
            report.stages += 1;
        }
        if report.stages > 1 && self.is_mostly_copies(workers) {
            self.resample(filter, count);
            // Copies of one particle do not give the length of steps: the first steps adapt it.
            self.walk(filter, step, measurement, (1.0, &mut stride), SPREADING_MOVES);
        }
        self.store(filter);
        report
    }

    /// Metropolis-Hastings steps in the space of the noise until each particle has made `enough`
    /// accepted ones on average: copies made by resampling must separate again, or there are fewer
    /// different particles than their number.
    ///
    /// Steps are in proportion to the remaining spread of the noise in each of its coordinates;
    /// their scale follows the share of accepted steps.
    fn walk(
        &mut self,
        filter: &mut ParticleFilter,
        step: &impl Transport,
        measurement: &impl Likelihood,
        (exponent, scale): (f64, &mut f64),
        enough: f64,
    ) {
        let spread = self.spread_of_noise().map(|spread| spread.max(MIN_STEP));
        let count = self.log_weights.len();
        let mut moved = 0.0;
        for _ in 0..MAX_STRIDES {
            let strides = spread.map(|spread| (*scale * spread).clamp(MIN_STEP, 0.95));
            let accepted = AtomicUsize::new(0);
            filter.for_each_part(&mut self.parts, |part, rng| {
                let walk = Walk { exponent, strides };
                accepted.fetch_add(part.walk(step, measurement, walk, rng), Ordering::Relaxed);
            });
            let rate = accepted.into_inner() as f64 / count.max(1) as f64;
            *scale = (*scale * (3.0 * (rate - ACCEPTANCE)).exp()).clamp(1e-3, 1e3);
            moved += rate;
            if moved >= enough {
                break;
            }
        }
    }

    /// Whether most of the weight lies on copies of a few particles. With uncertain odometry a
    /// single particle may lie within the peak of a scan, and its copies, from which no step leads
    /// to a better pose, soon outweigh all others.
    fn is_mostly_copies(&mut self, workers: &Workers) -> bool {
        let parts = self.parts.iter_mut().zip(self.log_weights.chunks(PART));
        let masses = workers.map(parts, |(part, weights)| part.without_copies(weights));
        let effective = Mass::total(masses).effective_sample_size();
        effective < MIN_DIFFERENT * self.log_weights.len() as f64
    }

    /// Standard deviations of the noise of the particles.
    fn spread_of_noise(&self) -> [f64; 4] {
        let (mut sums, mut squares, mut count) = ([0.0; 4], [0.0; 4], 0.0_f64);
        for noise in self.parts.iter().flat_map(|part| &part.noise) {
            for k in 0..4 {
                sums[k] += noise[k];
                squares[k] += noise[k] * noise[k];
            }
            count += 1.0;
        }
        std::array::from_fn(|k| {
            let mean = sums[k] / count.max(1.0);
            (squares[k] / count.max(1.0) - mean * mean).max(0.0).sqrt()
        })
    }

    /// Divides the particles into parts.
    fn load(&mut self, workers: &Workers, particles: &Particles) {
        self.parts.resize_with(particles.len().div_ceil(PART), Part::default);
        let parts = self.parts.iter_mut().zip(particles.poses().chunks(PART));
        workers.for_each(parts, |(part, poses)| part.load(poses));
        self.log_weights.clear();
        self.log_weights.extend_from_slice(particles.log_weights());
    }

    /// The poses after the motion, with normalised weights.
    fn store(&self, filter: &mut ParticleFilter) {
        let workers = filter.workers().clone();
        let particles = filter.particles_mut();
        particles.resize(self.log_weights.len());
        let (poses, log_weights) = particles.columns_mut();
        let targets = poses.chunks(PART).zip(log_weights.chunks_mut(PART));
        let parts = self.parts.iter().zip(self.log_weights.chunks(PART));
        workers.for_each(targets.zip(parts), |((poses, log_weights), (part, weights))| {
            let moved = part.moved.poses();
            poses.x.copy_from_slice(moved.x);
            poses.y.copy_from_slice(moved.y);
            poses.theta.copy_from_slice(moved.theta);
            log_weights.copy_from_slice(weights);
        });
        filter.normalize();
    }

    /// The largest share of the measurement, up to `rest`, that leaves enough particles effective.
    fn share_of(&mut self, workers: &Workers, rest: f64) -> f64 {
        let enough = self.settings.effective_share * self.log_weights.len() as f64;
        if self.effective_after(workers, rest) >= enough {
            return rest;
        }
        let (mut low, mut high) = (0.0, rest);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            let suffices = self.effective_after(workers, middle) >= enough;
            if suffices { low = middle } else { high = middle }
        }
        // At least a small share: a peak that no particle has found yet is still reached.
        low.max(rest / f64::from(1 << BISECTIONS))
    }

    /// Effective sample size after a share of the measurement.
    fn effective_after(&mut self, workers: &Workers, share: f64) -> f64 {
        self.weigh(workers, share).effective_sample_size()
    }

    /// Fills `after` with the weights after a share of the measurement.
    fn weigh(&mut self, workers: &Workers, share: f64) -> Mass {
        self.after.resize(self.log_weights.len(), 0.0);
        let parts = self.parts.iter().zip(self.log_weights.chunks(PART));
        let parts = parts.zip(self.after.chunks_mut(PART));
        Mass::total(workers.map(parts, |((part, weights), after)| {
            Mass::after(weights, share, part.log_likelihoods(), after)
        }))
    }

    /// Weights by a share of the measurement; returns the logarithm of the mean likelihood.
    fn apply(&mut self, workers: &Workers, share: f64) -> f64 {
        let before = Mass::total(workers.map(self.log_weights.chunks(PART), Mass::of));
        let after = self.weigh(workers, share);
        std::mem::swap(&mut self.log_weights, &mut self.after);
        match (before.log_sum(), after.log_sum()) {
            (Some(before), Some(after)) => after - before,
            _ => f64::NEG_INFINITY,
        }
    }

    /// Draws particles in proportion to their weights, with their parents and noise.
    fn resample(&mut self, filter: &mut ParticleFilter, count: usize) {
        let workers = filter.workers().clone();
        let (scheme, rng) = (Resampling::Systematic, filter.rng_mut());
        self.cumulative.set_by(&workers, &self.log_weights);
        scheme.draw_by(&workers, &self.cumulative, count, rng, &mut self.indices);
        std::mem::swap(&mut self.parts, &mut self.spare);
        self.parts.resize_with(count.div_ceil(PART), Part::default);
        let parts = self.parts.iter_mut().zip(self.indices.chunks(PART));
        workers.for_each(parts, |(part, indices)| part.gather(&self.spare, indices));
        self.log_weights.clear();
        self.log_weights.resize(count, -(count as f64).ln());
    }
}

/// Minimum length of a step, in units of the noise of the motion.
const MIN_STEP: f64 = 0.01;

/// Share of different particles below which there are too few.
const MIN_DIFFERENT: f64 = 0.1;

/// Accepted steps after which copies of one particle have spread over a peak.
const SPREADING_MOVES: f64 = 3.0;

/// Maximum number of stages; the last one uses the rest of the measurement.
const MAX_STAGES: usize = 20;

/// Target share of accepted steps, in (0, 1); their length follows it.
const ACCEPTANCE: f64 = 0.35;

/// Maximum number of steps of the particles in a stage.
const MAX_STRIDES: usize = 10;

/// How finely a share of a measurement is determined: to 1 / 2^10 of what is left.
const BISECTIONS: u32 = 10;

loc_core::settings! {
    /// Settings of [`Tempering`].
    #[derive(Copy)]
    pub struct TemperingSettings {
        /// A stage uses the share of the measurement that leaves this share of the particles
        /// effective, in (0, 1).
        pub effective_share: f64 = 0.5 => holds(
            "a share above 0 and below 1",
            |t| t.effective_share > 0.0 && t.effective_share < 1.0
        );
        /// Particles make steps until this many are accepted for each of them on average ..
        pub moves: f64 = 0.5 => positive;
    }
}

/// Particles with their poses before the motion and the noise of their motion.
#[derive(Debug, Clone, Default)]
struct Part {
    /// Poses before the motion.
    parents: Particles,
    /// The noise of the motion of each of them.
    noise: Vec<[f64; 4]>,
    /// Poses after it, with their log-likelihoods.
    moved: Particles,
    trial: Particles,
    trial_noise: Vec<[f64; 4]>,
    singles: Vec<f64>,
}

/// A Metropolis-Hastings step in the space of the noise.
#[derive(Debug, Clone, Copy)]
struct Walk {
    /// Share of the measurement used so far.
    exponent: f64,
    /// Standard deviations of a step, in (0, 1).
    strides: [f64; 4],
}

impl Part {
    /// Starts from some poses.
    fn load(&mut self, parents: Poses<'_>) {
        self.parents.refill(parents.iter(), std::iter::repeat_n(0.0, parents.len()));
    }

    /// Copies particles of other parts, with their parents, noise and log-likelihoods; `indices`
    /// count through all parts, each of which is `PART` long but the last.
    fn gather(&mut self, others: &[Part], indices: &[u32]) {
        let sources = indices.iter().map(|&index| (index as usize / PART, index as usize % PART));
        let parents = sources.clone().map(|(part, k)| others[part].parents.pose(k));
        self.parents.refill(parents, std::iter::repeat_n(0.0, indices.len()));
        self.noise.clear();
        self.noise.extend(sources.clone().map(|(part, k)| others[part].noise[k]));
        let moved = sources.clone().map(|(part, k)| others[part].moved.pose(k));
        self.moved.refill(moved, sources.map(|(part, k)| others[part].moved.log_weights()[k]));
    }

    /// The log-likelihoods of its particles.
    fn log_likelihoods(&self) -> &[f64] {
        self.moved.log_weights()
    }

    /// Draws the motion of every particle and rates the new pose.
    fn draw(&mut self, step: &impl Transport, measurement: &impl Likelihood, rng: &mut ChaCha8Rng) {
        self.noise.clear();
        self.noise.extend((0..self.parents.len()).map(|_| normals(rng)));
        move_all(&self.parents, &self.noise, step, &mut self.moved);
        rate(&mut self.moved, measurement);
    }

    /// The weights with copies counted as one; resampling leaves copies side by side.
    fn without_copies(&mut self, log_weights: &[f64]) -> Mass {
        self.singles.clear();
        let mut first = 0;
        for (k, weight) in log_weights.iter().enumerate() {
            if self.noise.get(k + 1).is_some_and(|next| is_copy(&self.noise[k], next)) {
                continue;
            }
            // Copies have the same weight.
            self.singles.push(weight + ((k + 1 - first) as f64).ln());
            first = k + 1;
        }
        Mass::of(&self.singles)
    }

    /// One Metropolis-Hastings step of each particle in the space of the noise; returns how many
    /// were accepted.
    ///
    /// The proposal `sqrt(1 - s^2) noise + s normal` leaves the distribution of the noise as it is
    /// (it is the preconditioned Crank-Nicolson proposal), so that only the likelihoods decide.
    fn walk(
        &mut self,
        step: &impl Transport,
        measurement: &impl Likelihood,
        walk: Walk,
        rng: &mut ChaCha8Rng,
    ) -> usize {
        let keep = walk.strides.map(|stride| (1.0 - stride * stride).sqrt());
        self.trial_noise.clear();
        self.trial_noise.extend(self.noise.iter().map(|noise| {
            let fresh = normals(rng);
            std::array::from_fn(|k| keep[k] * noise[k] + walk.strides[k] * fresh[k])
        }));
        move_all(&self.parents, &self.trial_noise, step, &mut self.trial);
        rate(&mut self.trial, measurement);
        let mut accepted = 0;
        for k in 0..self.noise.len() {
            let (old, new) = (self.moved.log_weights()[k], self.trial.log_weights()[k]);
            let chance: f64 = rng.random();
            // Where both are impossible the difference is NaN: the step is accepted.
            let gain = walk.exponent * (new - old);
            if gain.is_nan() || chance < gain.exp() {
                accepted += 1;
                self.noise[k] = self.trial_noise[k];
                self.moved.set_pose(k, self.trial.pose(k));
                self.moved.log_weights_mut()[k] = new;
            }
        }
        accepted
    }
}

/// Copies have the same noise to the bit.
fn is_copy(one: &[f64; 4], other: &[f64; 4]) -> bool {
    one.map(f64::to_bits) == other.map(f64::to_bits)
}

fn normals<R: Rng + ?Sized>(rng: &mut R) -> [f64; 4] {
    std::array::from_fn(|_| StandardNormal.sample(rng))
}

fn move_all(from: &Particles, noise: &[[f64; 4]], step: &impl Transport, to: &mut Particles) {
    to.clear();
    for (pose, noise) in from.poses().iter().zip(noise) {
        to.push(step.moved(pose, *noise), 0.0);
    }
}

fn rate(particles: &mut Particles, measurement: &impl Likelihood) {
    let (poses, log_likelihoods) = particles.poses_and_log_weights();
    measurement.rate(poses, log_likelihoods);
}
