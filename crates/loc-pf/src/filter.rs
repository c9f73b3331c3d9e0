//! The particle filter: sample motion, weight, resample (M1).
//!
//! ```
//! use loc_core::random::stream;
//! use loc_core::{Gaussian, Pose2, gaussian::pose_belief};
//! use loc_pf::{ParticleFilter, Particles, Resampling};
//! let mut rng = stream(1, "filter");
//! let start = pose_belief(Pose2::IDENTITY, [1.0, 1.0, 0.1]);
//! let mut filter = ParticleFilter::new(Particles::from_gaussian(&start, 1000, &mut rng), rng);
//! // A wall 5 m ahead is measured at 4.5 m, give or take 0.1 m.
//! filter.weigh(&|pose: Pose2| -0.5 * ((5.0 - pose.x - 4.5) / 0.1_f64).powi(2));
//! filter.normalize();
//! filter.resample(Resampling::Systematic, 1000);
//! let mean = filter.particles().poses().x.iter().sum::<f64>() / 1000.0;
//! assert!((mean - 0.5).abs() < 0.05);
//! ```

use crate::resample::CumulativeWeights;
use crate::{Kld, KldSettings, Likelihood, Motion, Particles, Resampling, Workers};
use loc_core::random::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Particles with their random generator and their threads.
#[derive(Debug)]
pub struct ParticleFilter {
    particles: Particles,
    /// The particles before the last resampling; kept for its memory.
    spare: Particles,
    cumulative: CumulativeWeights,
    indices: Vec<u32>,
    rng: ChaCha8Rng,
    workers: Workers,
}

/// Figures of a correction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weighing {
    /// Logarithm of the mean likelihood; -inf where no particle can explain the measurement.
    pub log_evidence: f64,
    /// Effective sample size afterwards; see [`Particles::effective_sample_size`].
    pub effective_sample_size: f64,
}

/// A copy has the particles and the generator; buffers and the particles before the last resampling
/// are not copied.
impl Clone for ParticleFilter {
    fn clone(&self) -> Self {
        ParticleFilter::new(self.particles.clone(), self.rng.clone())
            .with_workers(self.workers.clone())
    }
}

impl ParticleFilter {
    /// A filter that starts from `particles` and draws from `rng`, on the calling thread.
    pub fn new(particles: Particles, rng: ChaCha8Rng) -> Self {
        let (spare, cumulative, indices) = (Particles::new(), CumulativeWeights::new(), Vec::new());
        ParticleFilter { particles, spare, cumulative, indices, rng, workers: Workers::one() }
    }

    /// The same with other threads; the results stay the same.
    #[must_use]
    pub fn with_workers(mut self, workers: Workers) -> Self {
        self.workers = workers;
        self
    }

    /// The threads.
    pub(crate) fn workers(&self) -> &Workers {
        &self.workers
    }

    /// The particles.
    pub fn particles(&self) -> &Particles {
        &self.particles
    }

    /// The particles, to change.
    pub fn particles_mut(&mut self) -> &mut Particles {
        &mut self.particles
    }

    /// The generator that the filter draws from.
    pub fn rng(&self) -> &ChaCha8Rng {
        &self.rng
    }

    /// The generator that the filter draws from, to draw from it outside the filter.
    pub fn rng_mut(&mut self) -> &mut ChaCha8Rng {
        &mut self.rng
    }

    /// Samples the motion of every particle (M4).
    pub fn predict(&mut self, motion: &impl Motion) {
        self.workers.sample(&mut self.particles, motion, &mut self.rng);
    }

    /// Multiplies every weight by the likelihood of a measurement at that particle (M5 to M7).
    pub fn weigh(&mut self, measurement: &impl Likelihood) {
        self.workers.rate(&mut self.particles, measurement);
    }

    /// Both [`weigh`](ParticleFilter::weigh) and [`normalize`](ParticleFilter::normalize), in one
    /// pass over the particles.
    pub fn correct(&mut self, measurement: &impl Likelihood) -> Weighing {
        let ParticleFilter { workers, particles, .. } = self;
        let mass = workers.rate_and_add_up(particles, measurement);
        let log_evidence = workers.divide_by(particles, &mass);
        let is_weighed = log_evidence > f64::NEG_INFINITY;
        let effective_sample_size =
            if is_weighed { mass.effective_sample_size() } else { particles.len() as f64 };
        Weighing { log_evidence, effective_sample_size }
    }

    /// Makes the weights add up to 1; see [`Particles::normalize`].
    pub fn normalize(&mut self) -> f64 {
        let mass = self.workers.add_up(&self.particles);
        self.workers.divide_by(&mut self.particles, &mass)
    }

    /// Draws `count` particles in proportion to their weights (M8, M9), which are equal afterwards.
    pub fn resample(&mut self, scheme: Resampling, count: usize) {
        let ParticleFilter { workers, cumulative, particles, rng, indices, .. } = self;
        cumulative.set_by(workers, particles.log_weights());
        scheme.draw_by(workers, cumulative, count, rng, indices);
        self.copy_drawn();
    }

    /// The same with the number of particles that their spread requires; returns it.
    pub fn resample_adaptively(&mut self, scheme: Resampling, kld: &mut Kld) -> usize {
        self.draw_adaptively(scheme, kld);
        self.copy_drawn();
        self.particles.len()
    }

    /// The particles before the last resampling, with its weights; empty before the first.
    pub fn resampled_from(&self) -> &Particles {
        &self.spare
    }

    /// The number of particles that their spread requires.
    pub fn count_needed(&mut self, kld: &mut Kld) -> usize {
        self.draw_adaptively(Resampling::Systematic, kld);
        self.indices.len()
    }

    fn draw_adaptively(&mut self, scheme: Resampling, kld: &mut Kld) {
        let ParticleFilter { workers, cumulative, particles, rng, indices, .. } = self;
        cumulative.set_by(workers, particles.log_weights());
        let KldSettings { min_particles, max_particles, .. } = *kld.settings();
        if min_particles == max_particles {
            return scheme.draw_by(workers, cumulative, max_particles, rng, indices);
        }
        kld.draw_by(workers, scheme, cumulative, particles.poses(), rng, indices);
    }

    fn copy_drawn(&mut self) {
        std::mem::swap(&mut self.particles, &mut self.spare);
        self.workers.copy_selected(&mut self.particles, &self.spare, &self.indices);
    }

    /// [`Particles::effective_sample_size`], by all threads.
    pub(crate) fn effective_sample_size(&self) -> f64 {
        self.workers.add_up(&self.particles).effective_sample_size()
    }

    /// Does `work` on every part, each with a random stream of its own.
    pub(crate) fn for_each_part<T: Send>(
        &mut self,
        parts: &mut [T],
        work: impl Fn(&mut T, &mut ChaCha8Rng) + Sync,
    ) {
        let seed = self.rng.next_u64();
        self.workers.for_each(parts.iter_mut().enumerate(), |(number, part)| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(number as u64);
            work(part, &mut rng);
        });
    }
}
