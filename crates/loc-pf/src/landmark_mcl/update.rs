//! One step of the filter: drive to the sightings, weigh by them, resample.

use super::LandmarkMcl;
use super::leg::legs;
use crate::estimate::moments;
use crate::sensor::landmark::{LandmarkLikelihood, SensorResetting, Trust, anywhere};
use crate::{Particles, Result};
use loc_core::motion::dead_reckon;
use loc_core::random::ChaCha8Rng;
use loc_core::{Gaussian, Pose2};
use loc_maps::Bounds;
use loc_sensors::landmark_camera::Sighting;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};

/// What [`LandmarkMcl::sightings`] did.
#[derive(Debug, Clone, PartialEq)]
pub struct SightingUpdate {
    /// How far each sighting is to be trusted at the new estimate, those of unknown landmarks last.
    pub trust: Vec<Trust>,
    /// Effective sample size after weighing.
    pub effective_sample_size: f64,
    /// Whether the cloud was resampled.
    pub resampled: bool,
    /// Number of particles that were put elsewhere because the sightings do not fit.
    pub replaced: usize,
}

/// Share of particles that a first sighting leaves anywhere: it may be wrong.
const LEFT_ANYWHERE: f64 = 0.1;

/// Largest step of roughening, in standard deviations of a sighting.
const LARGEST_STEP: f64 = 0.25;

impl LandmarkMcl {
    /// Moves cloud and belief on to a time \[s\]; not back.
    pub(super) fn drive_to(&mut self, stamp: f64) {
        let from = self.state.stamp;
        if stamp <= from {
            return;
        }
        let (integration, noise) = (self.settings.integration, &self.settings.motion_noise);
        for leg in legs(self.velocities.between(from, stamp), integration, noise) {
            self.filter.predict(&leg);
        }
        let drive = self.velocities.between(from, stamp);
        self.state.belief = drive.fold(self.state.belief, |belief, hold| {
            dead_reckon(&belief, hold.twist, hold.duration, integration, noise)
        });
        self.state.stamp = stamp;
    }

    /// Takes in sightings at a time \[s\] not before the last ones.
    pub(super) fn take_in(&mut self, stamp: f64, sightings: &[Sighting]) -> Result<SightingUpdate> {
        let likelihood = LandmarkLikelihood::new(&self.map, sightings, &self.settings.sights)?;
        self.drive_to(stamp);
        if likelihood.is_empty() {
            return Ok(SightingUpdate {
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
        }
        Ok(SightingUpdate { trust, effective_sample_size, resampled, replaced })
    }

    /// Weighs the cloud; answers with the share of particles to replace.
    fn weigh(&mut self, likelihood: &LandmarkLikelihood) -> f64 {
        self.filter.weigh(likelihood);
        let log_mean = self.filter.normalize();
        let (log_peak, count) = (likelihood.log_peak(), likelihood.len());
        self.state.fit.update(log_mean, log_peak, count, &self.settings.recovery)
    }

    /// Puts the cloud where the sightings may have been made.
    fn gather(&mut self, likelihood: &LandmarkLikelihood) {
        let resetting = SensorResetting::new(likelihood, self.region);
        let (count, region) = (self.settings.particles, self.region);
        let rng = self.filter.rng_mut();
        let left = (LEFT_ANYWHERE * count as f64) as usize;
        let draw = |k| if k < left { anywhere(&region, rng) } else { resetting.draw(rng) };
        let cloud = Particles::from_poses((0..count).map(draw));
        *self.filter.particles_mut() = cloud;
    }

    /// Draws a new cloud, `replaced` of it from the sightings.
    fn resample(&mut self, likelihood: &LandmarkLikelihood, replaced: usize) {
        let kept = self.settings.particles - replaced;
        self.filter.resample(self.settings.resampling, kept);
        self.roughen();
        let resetting = SensorResetting::new(likelihood, self.region);
        let share = self.settings.recovery.sensor_resetting;
        for _ in 0..replaced {
            let rng = self.filter.rng_mut();
            let by_sight = rng.random::<f64>() < share;
            let pose = if by_sight { resetting.draw(rng) } else { anywhere(&self.region, rng) };
            self.filter.particles_mut().push(pose, 0.0);
        }
        self.filter.particles_mut().set_equal_weights();
    }

    /// Moves copies of one particle apart (Gordon, Salmond and Smith 1993).
    fn roughen(&mut self) {
        let Gaussian { covariance, .. } = &self.state.belief;
        let noise = &self.settings.sights.noise;
        let largest = [noise.range_sigma, noise.range_sigma, noise.bearing_sigma];
        let steps: [f64; 3] = std::array::from_fn(|k| {
            let spread = covariance[(k, k)].max(0.0).sqrt();
            (self.settings.roughening * spread).min(LARGEST_STEP * largest[k])
        });
        for k in 0..self.filter.particles().len() {
            let Pose2 { x, y, theta } = self.filter.particles().pose(k);
            let rng = self.filter.rng_mut();
            let [dx, dy, turn] = steps.map(|step| {
                let unit: f64 = StandardNormal.sample(rng);
                step * unit
            });
            self.filter.particles_mut().set_pose(k, Pose2::new(x + dx, y + dy, theta + turn));
        }
    }
}

/// Poses anywhere in a region.
pub(super) fn scattered(region: &Bounds, count: usize, rng: &mut ChaCha8Rng) -> Particles {
    Particles::from_poses((0..count).map(|_| anywhere(region, rng)))
}
