//! Finding the robot anywhere in the map: at a start from nowhere, and when it seems lost.

use super::belief::Belief;
use super::surroundings::Surroundings;
use crate::{Likelihood, Particles, Transport};
use loc_core::Pose2;
use loc_maps::likelihood_field::Endpoints;
use std::f64::consts::TAU;

/// Standard deviations around a place that a search found \[m, m, rad\]: its grid of poses is
/// about as coarse.
const SPREAD: [f64; 3] = [0.1, 0.1, 0.035];

/// Particles around a place as drawn from a normal distribution.
struct Spread;

impl Transport for Spread {
    fn moved(&self, pose: Pose2, noise: [f64; 4]) -> Pose2 {
        let [x, y, theta] = SPREAD;
        Pose2::new(pose.x + x * noise[0], pose.y + y * noise[1], pose.theta + theta * noise[2])
    }
}

/// What a search of the map found.
pub(super) struct Elsewhere {
    /// Where the robot may be, with normalised weights.
    pub(super) cloud: Particles,
    /// ln(mean likelihood of the scan over the whole map).
    pub(super) log_evidence: f64,
}

impl Belief {
    /// The places of the map where a scan fits; `None` where no place does, or no beam says
    /// anything, and without a search.
    pub(super) fn look_everywhere(
        &mut self,
        map: &Surroundings,
        scan: &impl Likelihood,
        endpoints: &Endpoints,
    ) -> Option<Elsewhere> {
        let places = map.search.as_ref()?.search(endpoints).ok()?;
        if places.is_empty() {
            return None;
        }
        let count = self.most_particles.max(places.len());
        let around = places.iter().cycle().take(count).map(|place| place.pose);
        let here = std::mem::replace(self.filter.particles_mut(), Particles::from_poses(around));
        let report = self.everywhere.update(&mut self.filter, &Spread, scan, count);
        let cloud = std::mem::replace(self.filter.particles_mut(), here);
        // Each place stands for the volume of its spread, the map for all of its free space.
        let volume = places.len() as f64 * TAU.powf(1.5) * SPREAD.iter().product::<f64>();
        let log_evidence = report.log_evidence + (volume / (map.free_space.area() * TAU)).ln();
        Some(Elsewhere { cloud, log_evidence })
    }

    /// Mixes what a search found into the cloud, with the probability of being there.
    pub(super) fn mix_in(&mut self, elsewhere: &Particles, probability: f64) {
        let cloud = self.filter.particles_mut();
        let shift = (1.0 - probability).ln();
        cloud.log_weights_mut().iter_mut().for_each(|weight| *weight += shift);
        let shift = probability.ln();
        for (pose, weight) in elsewhere.poses().iter().zip(elsewhere.log_weights()) {
            cloud.push(pose, weight + shift);
        }
        cloud.normalize();
    }
}
