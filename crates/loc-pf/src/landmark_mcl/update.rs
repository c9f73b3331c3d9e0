//! One step of the filter: drive to the observations, weigh by them, resample.

use super::settings::RecoverySettings;
use super::velocities::legs;
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
    /// How far each observation is to be trusted at the new estimate, those of unknown landmarks last.
    pub trust: Vec<Trust>,
    /// Effective sample size after weighing.
    pub effective_sample_size: f64,
    /// Whether the particle set was resampled.
    pub resampled: bool,
    /// Number of particles that were put elsewhere because the observations do not fit.
    pub replaced: usize,
}

/// Share of particles that a first observation leaves anywhere: it may be wrong.
const LEFT_ANYWHERE: f64 = 0.1;

/// Share of the particles that must carry weight after a part of the observations.
const ENOUGH: f64 = 0.05;

/// Most parts in which observations are taken in.
const STAGES: usize = 4;

/// How finely the part is searched.
const HALVINGS: usize = 8;

/// Largest step of roughening, in standard deviations of an observation.
const LARGEST_STEP: f64 = 0.25;

impl LandmarkMcl {
    /// Moves cloud and belief on to a time \[s\]; not back.
    pub(super) fn predict_to(&mut self, stamp: f64) {
        let from = self.state.stamp;
        if stamp <= from {
            return;
        }
        let (integration, noise) = (self.settings.integration, &self.settings.motion_noise);
        self.state.stamp = stamp;
        let Ok(legs) = legs(self.velocities.between(from, stamp), integration, noise) else {
            // Further than any robot drives, it may be anywhere.
            let count = self.settings.particles;
            let cloud = scattered(&self.region, count, Arc::make_mut(&mut self.filter).rng_mut());
            self.state = State { belief: moments(&cloud), anywhere: true, ..self.state };
            *Arc::make_mut(&mut self.filter).particles_mut() = cloud;
            return;
        };
        let filter = Arc::make_mut(&mut self.filter);
        legs.iter().for_each(|leg| filter.predict(leg));
        let drive = self.velocities.between(from, stamp);
        self.state.belief = drive.fold(self.state.belief, |belief, hold| {
            dead_reckon(&belief, hold.twist, hold.duration, integration, noise)
        });
    }

    /// Takes in observations at a time \[s\] not before the last ones.
    pub(super) fn correct_with(
        &mut self,
        stamp: f64,
        observations: &[LandmarkObservation],
    ) -> Result<ObservationUpdate> {
        let likelihood = LandmarkLikelihood::new(&self.map, observations, &self.settings.sights)?;
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
            self.gather(&likelihood);
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

    /// Weighs the particle set; answers with the share of particles to replace.
    ///
    /// Where only a handful of particles would carry all the weight, the observations are taken in by
    /// degrees: a part of the log-likelihood that leaves enough of them, a new particle set drawn, and then
    /// the rest (progressive correction, Oudjane and Musso 2000).
    fn weigh(&mut self, likelihood: &LandmarkLikelihood) -> f64 {
        let enough = ENOUGH * self.settings.particles as f64;
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
            let part =
                if stage == 0 || carried { rest } else { bearable(&before, &rated, rest, enough) };
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

    /// Weighs by a power of the likelihood, from the weights before.
    fn set_weights(&mut self, before: &[f64], rated: &[f64], power: f64) {
        let weights = Arc::make_mut(&mut self.filter).particles_mut().log_weights_mut();
        for (weight, (before, rated)) in weights.iter_mut().zip(before.iter().zip(rated)) {
            *weight = before + power * rated;
        }
    }

    /// Puts the particle set where the observations may have been made.
    fn gather(&mut self, likelihood: &LandmarkLikelihood) {
        let resetting = SensorResetting::new(likelihood, self.region);
        let (count, region) = (self.settings.particles, self.region);
        let rng = Arc::make_mut(&mut self.filter).rng_mut();
        let left = (LEFT_ANYWHERE * count as f64) as usize;
        let draw = |k| if k < left { anywhere(&region, rng) } else { resetting.draw(rng) };
        let cloud = Particles::from_poses((0..count).map(draw));
        *Arc::make_mut(&mut self.filter).particles_mut() = cloud;
    }

    /// Draws a new particle set, `replaced` of it from the observations.
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

    /// Moves copies of one particle apart and the particle set together by as much, so that its mean and
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

    /// Width of the kernel in standard deviations of the particle set: the one that suits a normal
    /// distribution (Silverman 1986), less where a particle set is so wide that it is none.
    fn kernel_width(&self) -> f64 {
        let covariance = &self.state.belief.covariance;
        let noise = &self.settings.sights.noise;
        let largest = [noise.range_sigma, noise.range_sigma, noise.bearing_sigma];
        let suits = (0.8 / self.settings.particles as f64).powf(1.0 / 7.0);
        let limits = (0..3).map(|k| {
            let sigma = covariance[(k, k)].max(f64::MIN_POSITIVE).sqrt();
            LARGEST_STEP * largest[k] / sigma
        });
        limits.fold(self.settings.roughening * suits, f64::min).min(1.0)
    }
}

/// Log-likelihoods from log weights with and without them. What was ruled out before stays so.
fn rated(after: &[f64], before: &[f64]) -> Vec<f64> {
    let gain =
        |(after, before): (&f64, &f64)| if *after > f64::MIN { after - before } else { *after };
    after.iter().zip(before).map(gain).collect()
}

/// The largest power, up to `rest`, of the likelihood that leaves `enough` particles; all of it
/// where not even the least part does: the observations then contradict the particle set.
fn bearable(before: &[f64], rated: &[f64], rest: f64, enough: f64) -> f64 {
    let (mut low, mut high) = (0.0, rest);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        let bears = sample_size(before, rated, middle) >= enough;
        if bears { low = middle } else { high = middle }
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

/// Poses anywhere in a region.
pub(super) fn scattered(region: &Bounds, count: usize, rng: &mut ChaCha8Rng) -> Particles {
    Particles::from_poses((0..count).map(|_| anywhere(region, rng)))
}

// How well the observations fit, now and in the long run (augmented MCL).

/// Two averages of the mean likelihood of an observation, as a share of the largest that it could have.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Fit {
    count: u32,
    slow: f64,
    fast: f64,
}

impl Fit {
    /// Takes in the observations of one moment: the logarithms of their mean likelihood over the particle set
    /// and of the largest possible one, and their number. Answers with the share of particles to
    /// replace.
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
