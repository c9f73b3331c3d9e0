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

use crate::resample::Wheel;
use crate::{Kld, Likelihood, Motion, Particles, Resampling, Workers};
use loc_core::random::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A cloud of particles with its randomness and its threads.
#[derive(Debug)]
pub struct ParticleFilter {
    particles: Particles,
    /// The particles before the last resampling; kept for its memory.
    spare: Particles,
    wheel: Wheel,
    indices: Vec<u32>,
    rng: ChaCha8Rng,
    workers: Workers,
}

impl ParticleFilter {
    /// A filter that starts from a cloud and draws from `rng`, on the calling thread.
    pub fn new(particles: Particles, rng: ChaCha8Rng) -> Self {
        let (spare, wheel, indices) = (Particles::new(), Wheel::new(), Vec::new());
        ParticleFilter { particles, spare, wheel, indices, rng, workers: Workers::one() }
    }

    /// The same with other threads; the results stay the same.
    #[must_use]
    pub fn with_workers(mut self, workers: Workers) -> Self {
        self.workers = workers;
        self
    }

    /// The cloud.
    pub fn particles(&self) -> &Particles {
        &self.particles
    }

    /// The cloud, to change.
    pub fn particles_mut(&mut self) -> &mut Particles {
        &mut self.particles
    }

    /// The generator that the filter draws from.
    pub fn rng(&self) -> &ChaCha8Rng {
        &self.rng
    }

    /// The generator that the filter draws from, to draw from it as well.
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

    /// Makes the weights add up to 1; see [`Particles::normalize`].
    pub fn normalize(&mut self) -> f64 {
        self.particles.normalize()
    }

    /// Draws `count` particles in proportion to their weights (M8, M9), which are equal afterwards.
    pub fn resample(&mut self, scheme: Resampling, count: usize) {
        self.wheel.set(self.particles.log_weights());
        scheme.spin(&self.wheel, count, &mut self.rng, &mut self.indices);
        self.copy_drawn();
    }

    /// The same with as many particles as the spread of the cloud asks for; says how many.
    pub fn resample_adaptively(&mut self, scheme: Resampling, kld: &mut Kld) -> usize {
        self.wheel.set(self.particles.log_weights());
        let poses = self.particles.poses();
        kld.draw(scheme, &self.wheel, poses, &mut self.rng, &mut self.indices);
        self.copy_drawn();
        self.particles.len()
    }

    /// The cloud before the last resampling, with its weights; empty before the first.
    pub fn resampled_from(&self) -> &Particles {
        &self.spare
    }

    /// How many particles the spread of the cloud asks for.
    pub fn count_needed(&mut self, kld: &mut Kld) -> usize {
        self.wheel.set(self.particles.log_weights());
        let (poses, scheme) = (self.particles.poses(), Resampling::Systematic);
        kld.draw(scheme, &self.wheel, poses, &mut self.rng, &mut self.indices);
        self.indices.len()
    }

    fn copy_drawn(&mut self) {
        std::mem::swap(&mut self.particles, &mut self.spare);
        self.particles.copy_selected(&self.spare, &self.indices);
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
