//! Monte Carlo localization in one dimension (M2): a corridor with doors that look all the same.
//!
//! The robot knows where the doors are but not where it is. It sees a door, drives on, and sees a
//! door again. Two of the doors are nearer to each other than any others: only whoever started at
//! the first of them sees a door twice. Five stages show the particles with their weights.

mod figure;

use super::count;
use crate::Result;
use crate::config::field;
use crate::output::Illustration;
use loc_core::Pose2;
use loc_core::error::{non_negative, positive};
use loc_core::random::stream;
use loc_pf::{ParticleFilter, Particles, Resampling};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use serde::Deserialize;
use serde_json::json;

/// The corridor, and what the robot does in it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mcl1dConfig {
    /// Length of the corridor.
    pub length_m: f64,
    /// The middles of the doors.
    pub doors_m: Vec<f64>,
    /// Where the robot really starts.
    pub start_m: f64,
    /// How far it drives between the two observations.
    pub drive_m: f64,
    /// Standard deviation of the way driven.
    pub drive_sigma_m: f64,
    /// How far from a door's middle a robot may be that sees it, as a standard deviation.
    pub door_sigma_m: f64,
    /// How likely a door is reported where none is, beside one right before it.
    pub false_door: f64,
    /// Number of particles.
    pub particles: usize,
}

impl Mcl1dConfig {
    pub(super) fn check(&self) -> Result<()> {
        positive("demonstration.length_m", self.length_m)?;
        let inside = |key: &str, place: f64| match place {
            place if (0.0..=self.length_m).contains(&place) => Ok(()),
            place => Err(field(key, "a place in the corridor", &place.to_string())),
        };
        self.doors_m.iter().try_for_each(|&door| inside("demonstration.doors_m", door))?;
        inside("demonstration.start_m", self.start_m)?;
        inside("demonstration.start_m + drive_m", self.start_m + self.drive_m)?;
        non_negative("demonstration.drive_sigma_m", self.drive_sigma_m)?;
        positive("demonstration.door_sigma_m", self.door_sigma_m)?;
        positive("demonstration.false_door", self.false_door)?;
        count("demonstration.particles", self.particles, 100_000)
    }

    /// How likely it is to report a door at a place, beside being right before one.
    pub fn likelihood(&self, place: f64) -> f64 {
        let nearness = |door: &f64| (-0.5 * ((place - door) / self.door_sigma_m).powi(2)).exp();
        self.false_door + self.doors_m.iter().map(nearness).sum::<f64>()
    }
}

/// The particles after one step of the filter.
#[derive(Debug, Clone)]
pub struct Stage {
    /// What has just happened.
    pub name: &'static str,
    /// Place \[m\] and weight of each particle.
    pub particles: Vec<(f64, f64)>,
    /// Where the robot really is \[m\].
    pub truth: f64,
    /// Whether the particles have just been weighed.
    pub weighed: bool,
}

/// The five stages of M2.
#[derive(Debug, Clone)]
pub struct Mcl1d {
    config: Mcl1dConfig,
    /// The stages a to e.
    pub stages: Vec<Stage>,
}

impl Mcl1d {
    /// Runs the filter through its stages.
    ///
    /// # Errors
    /// Values out of range.
    pub fn new(config: &Mcl1dConfig, seed: u64) -> Result<Self> {
        config.check()?;
        let mut rng = stream(seed, "demonstration");
        let at = |place: f64| Pose2::new(place, 0.0, 0.0);
        // Evenly spread, so that the prior looks like what it is.
        let spread = |k: usize, u: f64| (k as f64 + u) / config.particles as f64;
        let places =
            (0..config.particles).map(|k| config.length_m * spread(k, rng.random::<f64>()));
        let cloud = Particles::from_poses(places.map(at));
        let mut filter = ParticleFilter::new(cloud, stream(seed, "filter"));
        let door = |pose: Pose2| config.likelihood(pose.x).ln();
        let drive = |pose: Pose2, rng: &mut loc_core::random::ChaCha8Rng| {
            let error: f64 = StandardNormal.sample(rng);
            // A wall ends the corridor.
            at((pose.x + config.drive_m + config.drive_sigma_m * error).clamp(0.0, config.length_m))
        };
        let mut demonstration = Mcl1d { config: config.clone(), stages: Vec::new() };
        let (start, end) = (config.start_m, config.start_m + config.drive_m);
        demonstration.keep("a: no idea", &filter, start, false);
        filter.weigh(&door);
        filter.normalize();
        demonstration.keep("b: a door is seen", &filter, start, true);
        filter.resample(Resampling::Systematic, config.particles);
        filter.predict(&drive);
        demonstration.keep("c: resampled, driven on", &filter, end, false);
        filter.weigh(&door);
        filter.normalize();
        demonstration.keep("d: a door is seen again", &filter, end, true);
        filter.resample(Resampling::Systematic, config.particles);
        demonstration.keep("e: resampled", &filter, end, false);
        Ok(demonstration)
    }

    fn keep(&mut self, name: &'static str, filter: &ParticleFilter, truth: f64, weighed: bool) {
        let cloud = filter.particles();
        let particles = cloud.poses().x.iter().copied().zip(cloud.weights()).collect();
        self.stages.push(Stage { name, particles, truth, weighed });
    }

    /// The stages as a figure and numbers.
    pub fn illustrate(&self, title: &str) -> Illustration {
        let mut lines = vec![format!(
            "{:<24}{:>10}{:>11}{:>12}",
            "stage", "mean [m]", "sigma [m]", "near truth"
        )];
        lines.extend(self.stages.iter().map(|stage| {
            let ([mean, sigma], near) = (stage.moments(), stage.near_truth());
            format!("{:<24}{mean:>10.2}{sigma:>11.2}{:>10.1} %", stage.name, 100.0 * near)
        }));
        let stages = self.stages.iter().map(|stage| {
            let [mean, sigma] = stage.moments();
            json!({
                "stage": stage.name,
                "truth_m": stage.truth,
                "mean_m": mean,
                "sigma_m": sigma,
                "share_near_truth": stage.near_truth(),
            })
        });
        let summary = json!({"particles": self.config.particles,
            "stages": stages.collect::<Vec<_>>()});
        Illustration::new(lines, summary, vec![figure::figure(self, title)])
    }
}

/// How near counts as near the truth \[m\].
const NEAR: f64 = 1.0;

impl Stage {
    /// Weighted mean and standard deviation \[m\].
    pub fn moments(&self) -> [f64; 2] {
        let mean: f64 = self.particles.iter().map(|(x, weight)| weight * x).sum();
        let squares = self.particles.iter().map(|(x, weight)| weight * (x - mean).powi(2));
        [mean, squares.sum::<f64>().sqrt()]
    }

    /// Total weight within 1 m of the truth.
    pub fn near_truth(&self) -> f64 {
        let near = self.particles.iter().filter(|(x, _)| (x - self.truth).abs() <= NEAR);
        near.map(|(_, weight)| weight).sum()
    }
}
