//! A second belief beside the tracked one: the robot may be elsewhere.
//!
//! One scan proves little. Among people it may fit a false place better than the true one, and a
//! particle set that follows it is lost. So the places that a search finds far away do not enter the
//! particle set. They are a belief of their own, the challenger, which is moved and weighed as the first
//! one is. Two judges watch both over the next scans: the likelihood of the scans, and the monitor
//! of [`crate::confidence`], which asks how the map explains all beams at the pose that a belief
//! reports, above all whether beams end behind walls, which no crowd can feign. The challenger
//! takes over once both call it clearly better and the monitor calls the tracked belief more wrong
//! than right. What was tracked before then challenges in turn, for a while.

use super::Mcl;
use super::belief::{Belief, Step};
use super::scan::{MountedScan, Surroundings, endpoints, select};
use crate::confidence::{LostMonitor, Tolerance};
use crate::recovery::Suspicion;
use crate::{Likelihood, Particles, Result, Transport};
use loc_core::Pose2;
use loc_maps::likelihood_field::Endpoints;
use std::f64::consts::TAU;

/// A belief that competes with the tracked one.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Challenger {
    particles: Particles,
    monitor: LostMonitor,
    /// Scans that it has taken in.
    scans: u32,
    /// How much better the scans fit there than at the tracked particle set, the one that led there left
    /// out: it was chosen for that \[nats\].
    gain: f64,
}

/// One belief is clearly better than the other from this difference on \[nats\]: odds of 20.
pub(super) const CLEARLY: f64 = 3.0;

/// A challenger is heard for at least so many scans ..
const HEARD: u32 = 3;

/// .. and at most for so many.
const PATIENCE: u32 = 10;

impl Challenger {
    /// A belief that nothing has been said about.
    pub(super) fn new(particles: Particles, monitor: LostMonitor) -> Self {
        Challenger { particles, monitor, scans: 0, gain: 0.0 }
    }

    /// Whether the monitor and the scans call it clearly better than the tracked belief.
    fn is_better_than(&self, tracked: &LostMonitor) -> bool {
        let (own, rival) = (tracked.log_odds(), self.monitor.log_odds());
        own > 0.0 && own - rival > CLEARLY && self.gain > CLEARLY
    }

    /// Where the map is poor, no place is ever credible by itself: then the better one must stay
    /// so for long.
    fn takes_over_from(&self, tracked: &LostMonitor) -> bool {
        let heard = if self.monitor.log_odds() < 0.0 { HEARD } else { PATIENCE };
        self.scans >= heard && self.is_better_than(tracked)
    }

    fn is_refuted_by(&self, tracked: &LostMonitor) -> bool {
        let is_worse = self.scans >= HEARD && self.monitor.log_odds() > 0.0;
        self.scans >= PATIENCE || is_worse && !self.is_better_than(tracked)
    }
}

impl Mcl {
    /// Lets the challenger take in the scans too or, if the tracked belief is suspected, looks for
    /// one. Says whether the map was searched.
    pub(super) fn challenge(&mut self, step: &Step, scans: &[MountedScan<'_>]) -> Result<bool> {
        if let Some(mut challenger) = self.challenger.take() {
            self.swap_particles(&mut challenger);
            let weighed = self.weigh_challenger(step, scans);
            self.swap_particles(&mut challenger);
            weighed?;
            challenger.gain += self.gain(&challenger.particles, scans)?;
            self.judge(&mut challenger, scans);
            self.decide(challenger);
            return Ok(false);
        }
        let is_suspected = self.belief.suspicion.is_some_and(|suspicion| suspicion.is_alarmed());
        if is_suspected && let Some(mut challenger) = self.look_elsewhere(scans)? {
            self.judge(&mut challenger, scans);
            self.challenger = Some(challenger);
        }
        Ok(is_suspected)
    }

    /// Moves and weighs the present particle set as the tracked one, with the beams that it expects.
    fn weigh_challenger(&mut self, step: &Step, scans: &[MountedScan<'_>]) -> Result<()> {
        let beams = scans.iter().map(|mounted| select(mounted.scan, &self.settings)).collect();
        let beams = self.familiar(step, scans, beams)?;
        let endpoints = self.agreeing(step, endpoints(scans, &beams, self.range_offset()));
        let scan = self.surroundings.observe(scans, &beams, &endpoints, &self.settings)?;
        self.belief.track_elsewhere(step, &scan);
        Ok(())
    }

    /// How much better scans fit at a particle set than at the tracked one \[nats\]. All beams count, those
    /// too that either would not expect.
    fn gain(&self, particles: &Particles, scans: &[MountedScan<'_>]) -> Result<f64> {
        let beams: Vec<_> = scans.iter().map(|s| select(s.scan, &self.settings)).collect();
        let endpoints = endpoints(scans, &beams, self.range_offset());
        let scan = self.surroundings.observe(scans, &beams, &endpoints, &self.settings)?;
        let tracked = self.belief.filter.particles();
        Ok(fit(&scan, particles) - fit(&scan, tracked))
    }

    /// Lets the monitor look at the pose that the challenger reports.
    fn judge(&mut self, challenger: &mut Challenger, scans: &[MountedScan<'_>]) {
        let Challenger { particles, monitor, .. } = challenger;
        let pose = self.clusterer.estimate(particles).belief.pose();
        let support = self.settings.lost.tolerance.support(particles, pose);
        monitor.update(self.rater.rate(pose, scans), support);
        challenger.scans += 1;
    }

    /// Whom to believe, and whether to go on with the other one.
    fn decide(&mut self, mut challenger: Challenger) {
        if challenger.takes_over_from(&self.monitor) {
            self.swap_particles(&mut challenger);
            std::mem::swap(&mut self.monitor, &mut challenger.monitor);
            (challenger.scans, challenger.gain) = (0, 0.0);
            self.estimate = self.clusterer.estimate(self.belief.filter.particles());
            self.belief.suspicion.iter_mut().for_each(Suspicion::clear);
        }
        if challenger.is_refuted_by(&self.monitor) {
            self.searched_in_vain();
        } else {
            self.challenger = Some(challenger);
        }
    }

    fn swap_particles(&mut self, challenger: &mut Challenger) {
        std::mem::swap(self.belief.filter.particles_mut(), &mut challenger.particles);
    }

    /// Looks for the robot where it is not tracked. What is found beside the reported pose goes into
    /// the particle set; another place makes a challenger.
    pub(super) fn look_elsewhere(
        &mut self,
        scans: &[MountedScan<'_>],
    ) -> Result<Option<Challenger>> {
        match self.look_around(scans)? {
            Found::Beside(beside) => {
                self.belief.mix_in(&beside, SHIFTED);
                self.estimate = self.clusterer.estimate(self.belief.filter.particles());
                self.belief.suspicion.iter_mut().for_each(Suspicion::clear);
                Ok(None)
            }
            Found::Elsewhere(particles) => {
                Ok(Some(Challenger::new(particles, LostMonitor::new(self.settings.lost)?)))
            }
            Found::Nothing => {
                self.searched_in_vain();
                Ok(None)
            }
        }
    }

    /// Looks about the reported pose, then over the whole map: slips of the wheels and wrong starts
    /// are commoner than being carried off. A place counts where the scans fit better than here.
    ///
    /// All beams are looked at, those too that a filter against people drops: it does so by what
    /// the tracked belief expects.
    fn look_around(&mut self, scans: &[MountedScan<'_>]) -> Result<Found> {
        let offset = self.range_offset();
        let Mcl { surroundings, belief, rater, clusterer, settings, .. } = self;
        let beams: Vec<_> = scans.iter().map(|s| select(s.scan, settings)).collect();
        let endpoints = endpoints(scans, &beams, offset);
        let scan = surroundings.observe(scans, &beams, &endpoints, settings)?;
        let mut shift = |pose: Pose2| {
            rater.rate(pose, scans).map_or(f64::INFINITY, |fit| settings.lost.shift(&fit))
        };
        let here = fit(&scan, belief.filter.particles());

        let Tolerance { distance, turn } = settings.lost.tolerance;
        let reported = self.estimate.belief.pose();
        let spread = Spread([0.5 * distance, 0.5 * distance, 0.5 * turn]);
        if let Some(beside) = belief.spread_over(&[reported], spread, surroundings, &scan)
            && fit(&scan, &beside.particles) > here + CLEARLY
        {
            let pose = clusterer.estimate(&beside.particles).belief.pose();
            if pose.distance(reported) < 2.0 * distance && shift(pose) < shift(reported).min(0.0) {
                return Ok(Found::Beside(beside.particles));
            }
        }
        let places = credible(surroundings.places(&endpoints), shift);
        let found = belief.spread_over(&places, SPREAD, surroundings, &scan);
        let found = found.filter(|found| fit(&scan, &found.particles) > here);
        Ok(found.map_or(Found::Nothing, |found| Found::Elsewhere(found.particles)))
    }

    /// Nothing came of a search. The next one waits, unless the robot is lost in any case.
    pub(super) fn searched_in_vain(&mut self) {
        let is_lost = self.monitor.probability() > 0.5;
        self.belief.suspicion.iter_mut().for_each(|suspicion| suspicion.put_off(is_lost));
    }
}

// Where else the robot may be, when the tracked belief is suspected.

/// Places are looked at if the scan makes them at most this much less credible than the best one
/// \[nats\].
const CREDIBLE: f64 = 1.0;

/// The share of the particle set that goes to a place beside it.
const SHIFTED: f64 = 0.95;

/// What a look around found.
enum Found {
    /// The robot beside the reported pose.
    Beside(Particles),
    /// Another place of the map.
    Elsewhere(Particles),
    Nothing,
}

/// The places at which the monitor finds the scans about as credible as at the best one. People
/// at 1 m around the robot look like a closet; but there other beams would go through walls.
fn credible(places: Vec<Pose2>, shift: impl FnMut(Pose2) -> f64) -> Vec<Pose2> {
    let shifts: Vec<f64> = places.iter().copied().map(shift).collect();
    let least = shifts.iter().copied().fold(f64::INFINITY, f64::min);
    let pairs = places.into_iter().zip(shifts);
    pairs.filter(|(_, shift)| *shift <= least + CREDIBLE).map(|(place, _)| place).collect()
}

// Finding the robot anywhere in the map: at a start from nowhere, and when it seems lost.

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
    pub(super) particles: Particles,
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

    /// A particle set about some places, weighed by a scan; the filter's own stays as it is.
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
        let particles = std::mem::replace(self.filter.particles_mut(), here);
        // Each place stands for the volume of its spread, the map for all of its free space.
        let volume = places.len() as f64 * TAU.powf(1.5) * spread.0.iter().product::<f64>();
        let log_evidence = report.log_evidence + (volume / (map.free_space.area() * TAU)).ln();
        Some(Elsewhere { particles, log_evidence })
    }

    /// Mixes what a search found into the particle set, with the probability of being there.
    pub(super) fn mix_in(&mut self, elsewhere: &Particles, probability: f64) {
        let particles = self.filter.particles_mut();
        let shift = (1.0 - probability).ln();
        particles.log_weights_mut().iter_mut().for_each(|weight| *weight += shift);
        let shift = probability.ln();
        for (pose, weight) in elsewhere.poses().iter().zip(elsewhere.log_weights()) {
            particles.push(pose, weight + shift);
        }
        particles.normalize();
    }
}

/// How well a scan fits at a particle set: the mean of its log-likelihoods \[nats\].
pub(super) fn fit(scan: &impl Likelihood, particles: &Particles) -> f64 {
    let mut ratings = vec![0.0; particles.len()];
    scan.rate(particles.poses(), &mut ratings);
    let pairs = ratings.iter().zip(particles.weights()).filter(|(_, weight)| *weight > 0.0);
    pairs.map(|(rating, weight)| rating * weight).sum()
}
