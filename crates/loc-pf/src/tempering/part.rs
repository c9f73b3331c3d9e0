//! A part of the particles during a tempered update.

use crate::log_weights::Mass;
use crate::workers::PART;
use crate::{Likelihood, Particles, Poses, Transport};
use loc_core::random::ChaCha8Rng;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

/// Particles with their poses before the motion and the noise of their motion.
#[derive(Debug, Clone, Default)]
pub(super) struct Part {
    /// Poses before the motion.
    pub(super) parents: Particles,
    /// The noise of the motion of each of them.
    pub(super) noise: Vec<[f64; 4]>,
    /// Poses after it, with their log-likelihoods.
    pub(super) moved: Particles,
    trial: Particles,
    trial_noise: Vec<[f64; 4]>,
    singles: Vec<f64>,
}

/// A Metropolis-Hastings step in the space of the noise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Walk {
    /// Share of the measurement used so far.
    pub(super) exponent: f64,
    /// Standard deviations of a step, in (0, 1).
    pub(super) strides: [f64; 4],
}

impl Part {
    /// Starts from some poses.
    pub(super) fn load(&mut self, parents: Poses<'_>) {
        self.parents.refill(parents.iter(), std::iter::repeat_n(0.0, parents.len()));
    }

    /// Copies particles of other parts, with their parents, noise and log-likelihoods; `indices`
    /// count through all parts, each of which is `PART` long but the last.
    pub(super) fn gather(&mut self, others: &[Part], indices: &[u32]) {
        let sources = indices.iter().map(|&index| (index as usize / PART, index as usize % PART));
        let parents = sources.clone().map(|(part, k)| others[part].parents.pose(k));
        self.parents.refill(parents, std::iter::repeat_n(0.0, indices.len()));
        self.noise.clear();
        self.noise.extend(sources.clone().map(|(part, k)| others[part].noise[k]));
        let moved = sources.clone().map(|(part, k)| others[part].moved.pose(k));
        self.moved.refill(moved, sources.map(|(part, k)| others[part].moved.log_weights()[k]));
    }

    /// The log-likelihoods of its particles.
    pub(super) fn log_likelihoods(&self) -> &[f64] {
        self.moved.log_weights()
    }

    /// Draws the motion of every particle and rates the new pose.
    pub(super) fn draw(
        &mut self,
        step: &impl Transport,
        measurement: &impl Likelihood,
        rng: &mut ChaCha8Rng,
    ) {
        self.noise.clear();
        self.noise.extend((0..self.parents.len()).map(|_| normals(rng)));
        move_all(&self.parents, &self.noise, step, &mut self.moved);
        rate(&mut self.moved, measurement);
    }

    /// The weights with copies counted as one; resampling leaves copies side by side.
    pub(super) fn without_copies(&mut self, log_weights: &[f64]) -> Mass {
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
    pub(super) fn walk(
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
