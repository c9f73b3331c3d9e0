//! Finding the robot anywhere in the map: at a start from nowhere, and when it seems lost.

use super::belief::Belief;
use super::surroundings::Surroundings;
use crate::{Likelihood, Particles, Transport};
use loc_core::Pose2;
use loc_maps::likelihood_field::Endpoints;
use std::f64::consts::TAU;

/// Standard deviations around a place that a search found \[m, m, rad\]: its grid of poses is
/// about as coarse.
pub(super) const SPREAD: Spread = Spread([0.1, 0.1, 0.035]);

/// Particles around a place as drawn from a normal distribution, by its standard deviations
/// \[m, m, rad\].
#[derive(Debug, Clone, Copy)]
pub(super) struct Spread(pub(super) [f64; 3]);

impl Transport for Spread {
    fn moved(&self, pose: Pose2, noise: [f64; 4]) -> Pose2 {
        let [x, y, theta] = self.0;
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
    /// Where the robot may be by a scan at a start from nowhere; `None` where no place fits, or no
    /// beam says anything, and without a search.
    pub(super) fn look_everywhere(
        &mut self,
        map: &Surroundings,
        scan: &impl Likelihood,
        endpoints: &Endpoints,
    ) -> Option<Elsewhere> {
        self.spread_over(&map.places(endpoints), SPREAD, map, scan)
    }

    /// A cloud about some places, weighed by a scan; the filter's own stays as it is.
    pub(super) fn spread_over(
        &mut self,
        places: &[Pose2],
        spread: Spread,
        map: &Surroundings,
        scan: &impl Likelihood,
    ) -> Option<Elsewhere> {
        if places.is_empty() {
            return None;
        }
        let count = self.max_particles.max(places.len());
        let around = places.iter().cycle().take(count).copied();
        let here = std::mem::replace(self.filter.particles_mut(), Particles::from_poses(around));
        let report = self.everywhere.update(&mut self.filter, &spread, scan, count);
        let cloud = std::mem::replace(self.filter.particles_mut(), here);
        // Each place stands for the volume of its spread, the map for all of its free space.
        let volume = places.len() as f64 * TAU.powf(1.5) * spread.0.iter().product::<f64>();
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

/// How well a scan fits at a cloud: the mean of its log-likelihoods \[nats\].
pub(super) fn fit(scan: &impl Likelihood, cloud: &Particles) -> f64 {
    let mut ratings = vec![0.0; cloud.len()];
    scan.rate(cloud.poses(), &mut ratings);
    let pairs = ratings.iter().zip(cloud.weights()).filter(|(_, weight)| *weight > 0.0);
    pairs.map(|(rating, weight)| rating * weight).sum()
}
