//! What is done to a cloud part by part.

use super::{PART, Workers};
use crate::log_weights::{self, Mass};
use crate::{Likelihood, Motion, Particles};
use loc_core::random::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

impl Workers {
    /// Moves every particle by `motion`.
    pub fn sample(&self, particles: &mut Particles, motion: &impl Motion, rng: &mut ChaCha8Rng) {
        let seed = rng.next_u64();
        self.for_each(particles.poses_mut().chunks(PART).enumerate(), |(part, poses)| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(part as u64);
            motion.sample(poses, &mut rng);
        });
    }

    /// Adds the log-likelihood of a measurement to the log weight of every particle.
    pub fn rate(&self, particles: &mut Particles, measurement: &impl Likelihood) {
        let (poses, weights) = particles.poses_and_log_weights();
        self.for_each(poses.chunks(PART).zip(weights.chunks_mut(PART)), |(poses, weights)| {
            measurement.rate(poses, weights);
        });
    }

    /// The same, and adds up the weights that come out.
    pub(crate) fn rate_and_add_up(
        &self,
        particles: &mut Particles,
        measurement: &impl Likelihood,
    ) -> Mass {
        let (poses, weights) = particles.poses_and_log_weights();
        let parts = poses.chunks(PART).zip(weights.chunks_mut(PART));
        Mass::total(self.map(parts, |(poses, weights)| {
            measurement.rate(poses, weights);
            Mass::of(weights)
        }))
    }

    /// Adds up the weights.
    pub(crate) fn add_up(&self, particles: &Particles) -> Mass {
        Mass::total(self.map(particles.log_weights().chunks(PART), Mass::of))
    }

    /// Makes weights add up to 1, of which `mass` is the sum; see [`Particles::normalize`].
    pub(crate) fn divide_by(&self, particles: &mut Particles, mass: &Mass) -> f64 {
        let Some(sum) = mass.log_sum() else {
            particles.set_equal_weights();
            return f64::NEG_INFINITY;
        };
        let parts = particles.log_weights_mut().chunks_mut(PART);
        self.for_each(parts, |weights| log_weights::divide(weights, sum));
        sum
    }

    /// [`Particles::copy_selected`].
    pub(crate) fn copy_selected(&self, to: &mut Particles, from: &Particles, indices: &[u32]) {
        to.resize(indices.len());
        let parts = to.poses_mut().chunks(PART).zip(indices.chunks(PART));
        self.for_each(parts, |(poses, indices)| poses.copy_selected(from.poses(), indices));
    }
}
