//! One update of the filter: move to the time of the observations, weight by them, resample.

use super::settings::RecoverySettings;
use super::velocities::segments;
use super::{LandmarkMcl, State};
use crate::estimate::moments;
use crate::sensor::landmark::{LandmarkLikelihood, SensorResetting, Trust, anywhere};
use crate::{Particles, Result};
use loc_core::motion::dead_reckon;
use loc_core::random::ChaCha8Rng;
use loc_core::{Pose2, angle};
use loc_maps::Bounds;
use loc_sensors::landmark_camera::LandmarkObservation;
use nalgebra::Vector3;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use std::sync::Arc;

/// What [`LandmarkMcl::update`] did.
#[derive(Debug, Clone, PartialEq)]
pub struct ObservationUpdate {
    /// Probability of each observation being right at the new estimate, those of unknown landmarks
    /// last.
    pub trust: Vec<Trust>,
    /// Effective sample size after weighting.
    pub effective_sample_size: f64,
    /// Whether the particles were resampled.
    pub resampled: bool,
    /// Number of particles that were replaced because the observations do not fit.
    pub replaced: usize,
}

/// Share of particles that stay uniform after a first observation: it may be wrong.
const UNIFORM_SHARE: f64 = 0.1;

/// Minimum effective share of the particles after a stage.
const MIN_EFFECTIVE_SHARE: f64 = 0.05;

/// Maximum number of stages of an update.
const STAGES: usize = 4;

/// Number of bisections for the share of a stage.
const HALVINGS: usize = 8;

/// Maximum step of roughening, in standard deviations of an observation.
const MAX_STEP: f64 = 0.25;

impl LandmarkMcl {
    /// Predicts particles and belief to a time \[s\]; not back.
    pub(super) fn predict_to(&mut self, stamp: f64) {
        let from = self.state.stamp;
        if stamp <= from {
            return;
        }
        let (integration, noise) = (self.settings.robot.integration, &self.settings.robot.odometry);
        self.state.stamp = stamp;
        let Ok(segments) = segments(self.velocities.between(from, stamp), integration, noise)
        else {
            // After a longer drive than possible, the robot may be anywhere.
            let count = self.settings.particles;
            let particles = uniform(&self.region, count, Arc::make_mut(&mut self.filter).rng_mut());
            self.state = State { belief: moments(&particles), anywhere: true, ..self.state };
            *Arc::make_mut(&mut self.filter).particles_mut() = particles;
            return;
        };
        let filter = Arc::make_mut(&mut self.filter);
        segments.iter().for_each(|segment| filter.predict(segment));
        let drive = self.velocities.between(from, stamp);
        self.state.belief = drive.fold(self.state.belief, |belief, interval| {
            dead_reckon(&belief, interval.twist, interval.duration, integration, noise)
        });
    }

    /// Updates with observations at a time \[s\] not before the last ones.
    pub(super) fn correct_with(
        &mut self,
        stamp: f64,
        observations: &[LandmarkObservation],
    ) -> Result<ObservationUpdate> {
        let likelihood =
            LandmarkLikelihood::new(&self.map, observations, &self.settings.observation_model())?;
        self.predict_to(stamp);
        self.state.resampled = false;
        if likelihood.is_empty() {
            return Ok(ObservationUpdate {
                trust: likelihood.trust(self.state.belief.pose()).collect(),
                effective_sample_size: self.filter.particles().effective_sample_size(),
                resampled: false,
                replaced: 0,
            });
        }
        if std::mem::take(&mut self.state.anywhere) {
            self.draw_from_observations(&likelihood);
        }
        let share = self.weigh(&likelihood);
        self.state.belief = moments(self.filter.particles());
        let trust = likelihood.trust(self.state.belief.pose()).collect();
        let count = self.settings.particles as f64;
        let replaced = (share * count).round().min(count) as usize;
        let effective_sample_size = self.filter.particles().effective_sample_size();
        let resampled =
            replaced > 0 || effective_sample_size < self.settings.resample_below * count;
        if resampled {
            self.resample(&likelihood, replaced);
            self.state.resampled = true;
        }
        Ok(ObservationUpdate { trust, effective_sample_size, resampled, replaced })
    }

    /// Weights the particles; returns the share of particles to replace.
    ///
    /// Where only a few particles would carry all the weight, the update is tempered: a share of
    /// the log-likelihood that leaves enough of them effective, resampling, and then the rest
    /// (progressive correction, Oudjane and Musso 2000).
    fn weigh(&mut self, likelihood: &LandmarkLikelihood) -> f64 {
        let enough = MIN_EFFECTIVE_SHARE * self.settings.particles as f64;
        let (mut log_mean, mut rest) = (0.0, 1.0);
        for stage in (0..STAGES).rev() {
            let before = self.filter.particles().log_weights().to_vec();
            Arc::make_mut(&mut self.filter).weigh(likelihood);
            let rated = rated(self.filter.particles().log_weights(), &before);
            if rest < 1.0 {
                self.set_weights(&before, &rated, rest);
            }
            let all = Arc::make_mut(&mut self.filter).normalize();
            let carried = self.filter.particles().effective_sample_size() >= enough;
            let part = if stage == 0 || carried {
                rest
            } else {
                largest_share(&before, &rated, rest, enough)
            };
            if part >= rest {
                log_mean += all;
                break;
            }
            self.set_weights(&before, &rated, part);
            log_mean += Arc::make_mut(&mut self.filter).normalize();
            rest -= part;
            self.state.belief = moments(self.filter.particles());
            Arc::make_mut(&mut self.filter)
                .resample(self.settings.resampling, self.settings.particles);
            self.roughen();
        }
        let (log_peak, count) = (likelihood.log_peak(), likelihood.len());
        self.state.fit.update(log_mean, log_peak, count, &self.settings.recovery)
    }

    /// Sets the weights before times a power of the likelihood.
    fn set_weights(&mut self, before: &[f64], rated: &[f64], power: f64) {
        let weights = Arc::make_mut(&mut self.filter).particles_mut().log_weights_mut();
        for (weight, (before, rated)) in weights.iter_mut().zip(before.iter().zip(rated)) {
            *weight = before + power * rated;
        }
    }

    /// Draws the particles where the observations may have been made.
    fn draw_from_observations(&mut self, likelihood: &LandmarkLikelihood) {
        let resetting = SensorResetting::new(likelihood, self.region);
        let (count, region) = (self.settings.particles, self.region);
        let rng = Arc::make_mut(&mut self.filter).rng_mut();
        let left = (UNIFORM_SHARE * count as f64) as usize;
        let draw = |k| if k < left { anywhere(&region, rng) } else { resetting.draw(rng) };
        let particles = Particles::from_poses((0..count).map(draw));
        *Arc::make_mut(&mut self.filter).particles_mut() = particles;
    }

    /// Resamples, with `replaced` particles from the observations.
    fn resample(&mut self, likelihood: &LandmarkLikelihood, replaced: usize) {
        let kept = self.settings.particles - replaced;
        Arc::make_mut(&mut self.filter).resample(self.settings.resampling, kept);
        self.roughen();
        let resetting = SensorResetting::new(likelihood, self.region);
        let share = self.settings.recovery.sensor_resetting;
        for _ in 0..replaced {
            let rng = Arc::make_mut(&mut self.filter).rng_mut();
            let by_observation = rng.random::<f64>() < share;
            let pose =
                if by_observation { resetting.draw(rng) } else { anywhere(&self.region, rng) };
            Arc::make_mut(&mut self.filter).particles_mut().push(pose, 0.0);
        }
        Arc::make_mut(&mut self.filter).particles_mut().set_equal_weights();
    }

    /// Adds noise to the particles and shrinks them towards their mean by as much, so that mean and
    /// covariance stay (Liu and West 2001).
    fn roughen(&mut self) {
        let mean = self.state.belief.mean;
        let width = self.kernel_width();
        if width <= 0.0 {
            return;
        }
        let kernel = width * self.state.belief.factor();
        let together = (1.0 - width * width).sqrt();
        for k in 0..self.filter.particles().len() {
            let mut deviation = self.filter.particles().pose(k).to_vector() - mean;
            deviation.z = angle::wrap(deviation.z);
            let rng = Arc::make_mut(&mut self.filter).rng_mut();
            let step = kernel * Vector3::from_fn(|_, _| StandardNormal.sample(rng));
            let pose = Pose2::from_vector(&(mean + together * deviation + step));
            Arc::make_mut(&mut self.filter).particles_mut().set_pose(k, pose);
        }
    }

    /// Width of the kernel in standard deviations of the particles: the one for a normal
    /// distribution (Silverman 1986), less for a wide belief, which is not normal.
    fn kernel_width(&self) -> f64 {
        let covariance = &self.state.belief.covariance;
        let noise = &self.settings.robot.camera;
        let largest = [noise.range_sigma, noise.range_sigma, noise.bearing_sigma];
        let suits = (0.8 / self.settings.particles as f64).powf(1.0 / 7.0);
        let limits = (0..3).map(|k| {
            let sigma = covariance[(k, k)].max(f64::MIN_POSITIVE).sqrt();
            MAX_STEP * largest[k] / sigma
        });
        limits.fold(suits, f64::min).min(1.0)
    }
}

/// Log-likelihoods from log weights with and without them. Excluded particles stay excluded.
fn rated(after: &[f64], before: &[f64]) -> Vec<f64> {
    let gain =
        |(after, before): (&f64, &f64)| if *after > f64::MIN { after - before } else { *after };
    after.iter().zip(before).map(gain).collect()
}

/// The largest power, up to `rest`, of the likelihood that leaves `enough` effective particles; all
/// of it where not even the smallest one does: the observations then contradict the particles.
fn largest_share(before: &[f64], rated: &[f64], rest: f64, enough: f64) -> f64 {
    let (mut low, mut high) = (0.0, rest);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        let suffices = sample_size(before, rated, middle) >= enough;
        if suffices { low = middle } else { high = middle }
    }
    if low > 0.0 { low } else { rest }
}

/// Effective sample size after weighing by a power of the likelihood.
fn sample_size(log_weights: &[f64], rated: &[f64], power: f64) -> f64 {
    let logarithms = || log_weights.iter().zip(rated).map(|(weight, rated)| weight + power * rated);
    let largest = logarithms().fold(f64::NEG_INFINITY, f64::max);
    let (sum, squares) = logarithms().fold((0.0, 0.0), |(sum, squares), logarithm| {
        let weight = (logarithm - largest).exp();
        (sum + weight, squares + weight * weight)
    });
    if squares > 0.0 { sum * sum / squares } else { 0.0 }
}

/// Particles drawn uniformly from a region.
pub(super) fn uniform(region: &Bounds, count: usize, rng: &mut ChaCha8Rng) -> Particles {
    Particles::from_poses((0..count).map(|_| anywhere(region, rng)))
}

/// How well the observations fit (augmented MCL): two averages of the mean likelihood of an
/// observation, as a share of the largest that it could have.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Fit {
    count: u32,
    slow: f64,
    fast: f64,
}

impl Fit {
    /// Updates with the observations of one time: the logarithms of their mean likelihood over the
    /// particles and of the largest possible one, and their number. Returns the share of particles
    /// to replace.
    pub(super) fn update(
        &mut self,
        log_mean: f64,
        log_peak: f64,
        count: usize,
        settings: &RecoverySettings,
    ) -> f64 {
        let now = ((log_mean - log_peak) / count.max(1) as f64).exp().clamp(0.0, 1.0);
        self.count = self.count.saturating_add(1);
        // The first ones are averaged evenly, so that neither average hangs on the very first.
        let first = f64::from(self.count).recip();
        self.slow += settings.alpha_slow.max(first) * (now - self.slow);
        self.fast += settings.alpha_fast.max(first) * (now - self.fast);
        let off = settings.alpha_fast <= 0.0 || self.fast * settings.factor >= self.slow;
        if off { 0.0 } else { 1.0 - self.fast / self.slow }
    }

    /// The slow and the fast average, each in \[0, 1\].
    pub(super) fn averages(&self) -> Option<[f64; 2]> {
        (self.count > 0).then_some([self.slow, self.fast])
    }
}
