//! Finding the robot elsewhere: at a start without knowledge of the pose, and when it seems lost.
//!
//! One scan is weak evidence. Among people it may fit a false pose better than the true one, and a
//! filter that follows it is lost. So the pose candidates that a search finds far away do not enter
//! the particle set. They become an [`Alternative`] hypothesis, which is moved and weighted as the
//! tracked belief is. Two criteria compare both over the next scans: the likelihood of the scans,
//! and the monitor of [`crate::confidence`], which rates how the map explains all beams at the pose
//! that a belief reports, above all whether beams end behind walls, which people cannot cause. The
//! alternative replaces the tracked belief once both criteria call it clearly better and the
//! monitor gives the tracked belief less than even odds. The belief that was tracked until then
//! becomes the alternative, for a limited number of scans.

use super::belief::{Belief, Step};
use super::scan::{Candidates, MountedScan, PreparedMap, endpoints};
use super::{Mcl, MotionModel, ScanModel};
use crate::confidence::{LostMonitor, Tolerance};
use crate::recovery::Suspicion;
use crate::{Likelihood, Particles, Result, Transport};
use loc_core::Pose2;
use loc_maps::likelihood_field::Endpoints;
use nalgebra::Matrix3;
use std::f64::consts::TAU;

/// An alternative hypothesis: a belief that is compared with the tracked one.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Alternative {
    particles: Particles,
    monitor: LostMonitor,
    /// Number of scans it was updated with.
    scans: u32,
    /// How much better the scans fit there than at the tracked particles \[nats\], without the scan
    /// by which it was found.
    gain: f64,
}

/// One belief is clearly better than the other from this difference on \[nats\]: odds of 20.
pub(super) const CLEARLY: f64 = 3.0;

/// An alternative is compared over at least this many scans ..
const MIN_SCANS: u32 = 3;

/// .. and at most this many.
const MAX_SCANS: u32 = 10;

/// Off the map, one of this many updates searches it.
const OFF_MAP: u32 = 10;

/// Places are looked at if the scan makes them at most this much less credible than the best one
/// \[nats\].
const CREDIBLE: f64 = 1.0;

/// The share of the weight for particles found beside the reported pose.
const SHIFTED: f64 = 0.95;

/// The result of a search.
enum Found {
    /// Particles beside the reported pose.
    Beside(Particles),
    /// Particles elsewhere in the map.
    Elsewhere(Particles),
    /// No pose where the scans fit better.
    Nothing,
}

impl<M: MotionModel, S: ScanModel> Mcl<M, S> {
    /// Updates the alternative with the scans or, if the tracked belief is doubtful, searches for
    /// one. Returns whether the map was searched.
    pub(super) fn update_alternative(
        &mut self,
        step: &Step<M::Step>,
        scans: &[MountedScan<'_>],
    ) -> Result<bool> {
        if let Some(mut alternative) = self.alternative.take() {
            self.swap_particles(&mut alternative);
            let weighed = self.weigh_alternative(step, scans);
            self.swap_particles(&mut alternative);
            weighed?;
            alternative.gain += self.gain(&alternative.particles, scans)?;
            self.observe_alternative(&mut alternative, scans);
            self.select_belief(alternative);
            return Ok(false);
        }
        // Off the map nothing raises suspicion. So the map is looked at now and then.
        let may_be_back =
            self.off_map > 0 && self.off_map.is_multiple_of(OFF_MAP) && self.lost() > 0.5;
        let is_suspected =
            self.belief.suspicion.is_some_and(|suspicion| suspicion.is_alarmed() || may_be_back);
        if is_suspected && let Some(mut alternative) = self.search_alternative(scans)? {
            self.observe_alternative(&mut alternative, scans);
            self.alternative = Some(alternative);
        }
        Ok(is_suspected)
    }

    /// Moves and weights the present particles as the tracked ones, with beams selected by them.
    fn weigh_alternative(&mut self, step: &Step<M::Step>, scans: &[MountedScan<'_>]) -> Result<()> {
        let beams = self.select(scans);
        let beams = self.without_novel(step, scans, beams)?;
        let endpoints = self.without_skipped(step, endpoints(scans, &beams, self.range_offset()));
        let view = self.map.view(scans, &beams, &endpoints);
        let scan = self.sensor.likelihood(&view)?;
        self.belief.track_alternative(step, &scan);
        Ok(())
    }

    /// How much better scans fit at some particles than at the tracked ones \[nats\]. All beams
    /// count, also those that a novelty filter would drop.
    fn gain(&self, particles: &Particles, scans: &[MountedScan<'_>]) -> Result<f64> {
        let beams = self.select(scans);
        let endpoints = endpoints(scans, &beams, self.range_offset());
        let view = self.map.view(scans, &beams, &endpoints);
        let scan = self.sensor.likelihood(&view)?;
        let tracked = self.belief.filter.particles();
        Ok(fit(&scan, particles) - fit(&scan, tracked))
    }

    /// Updates the monitor of the alternative with the pose that it reports.
    fn observe_alternative(&mut self, alternative: &mut Alternative, scans: &[MountedScan<'_>]) {
        let Alternative { particles, monitor, .. } = alternative;
        let pose = self.clusterer.estimate(particles).belief.pose();
        let support = self.settings.lost.tolerance.support(particles, pose);
        monitor.update(self.rater.rate(pose, scans), support);
        alternative.scans += 1;
    }

    /// Selects the belief to track, and drops or keeps the other one.
    fn select_belief(&mut self, mut alternative: Alternative) {
        if alternative.replaces(&self.monitor) {
            self.swap_particles(&mut alternative);
            std::mem::swap(&mut self.monitor, &mut alternative.monitor);
            (alternative.scans, alternative.gain) = (0, 0.0);
            self.cluster();
            self.belief.suspicion.iter_mut().for_each(Suspicion::clear);
        }
        if alternative.is_refuted_by(&self.monitor) {
            self.postpone_search();
        } else {
            self.alternative = Some(alternative);
        }
    }

    fn swap_particles(&mut self, alternative: &mut Alternative) {
        std::mem::swap(self.belief.filter.particles_mut(), &mut alternative.particles);
    }

    /// Searches for the robot where it is not tracked. Particles found beside the reported pose
    /// enter the particle set; candidates elsewhere become the alternative.
    pub(super) fn search_alternative(
        &mut self,
        scans: &[MountedScan<'_>],
    ) -> Result<Option<Alternative>> {
        match self.search(scans)? {
            Found::Beside(beside) => {
                self.belief.add_weighted(&beside, SHIFTED);
                self.cluster();
                self.belief.suspicion.iter_mut().for_each(Suspicion::clear);
                Ok(None)
            }
            Found::Elsewhere(particles) => {
                Ok(Some(Alternative::new(particles, LostMonitor::new(self.settings.lost)?)))
            }
            Found::Nothing => {
                self.postpone_search();
                Ok(None)
            }
        }
    }

    /// Searches around the reported pose, then over the whole map: wheel slip and wrong initial
    /// poses are more frequent than kidnapping. A candidate counts where the scans fit better than
    /// at the tracked belief.
    ///
    /// All beams are used, also those that a novelty filter drops: it selects by the tracked
    /// belief.
    fn search(&mut self, scans: &[MountedScan<'_>]) -> Result<Found> {
        let offset = self.range_offset();
        let beams = self.select(scans);
        let Mcl { map, belief, rater, clusterer, settings, sensor, .. } = self;
        let endpoints = endpoints(scans, &beams, offset);
        let view = map.view(scans, &beams, &endpoints);
        let scan = sensor.likelihood(&view)?;
        let mut shift = |pose: Pose2| {
            rater.rate(pose, scans).map_or(f64::INFINITY, |fit| settings.lost.shift(&fit))
        };
        let here = fit(&scan, belief.filter.particles());

        let Tolerance { distance, turn } = settings.lost.tolerance;
        let reported = self.estimate.belief.pose();
        let spread = Spread([0.5 * distance, 0.5 * distance, 0.5 * turn]);
        if let Some(beside) = belief.spread_over(&Candidates::one(reported), spread, map, &scan)
            && fit(&scan, &beside.particles) > here + CLEARLY
        {
            let pose = clusterer.estimate(&beside.particles).belief.pose();
            if pose.distance(reported) < 2.0 * distance && shift(pose) < shift(reported).min(0.0) {
                return Ok(Found::Beside(beside.particles));
            }
        }
        let candidates = map.candidates(&endpoints).credible(shift);
        let found = belief.spread_over(&candidates, SPREAD, map, &scan);
        let found = found.filter(|found| fit(&scan, &found.particles) > here);
        Ok(found.map_or(Found::Nothing, |found| Found::Elsewhere(found.particles)))
    }

    /// After a search without result: the next one is postponed, unless the robot is lost anyway.
    pub(super) fn postpone_search(&mut self) {
        let is_lost = self.monitor.probability() > 0.5;
        self.belief.suspicion.iter_mut().for_each(|suspicion| suspicion.postpone(is_lost));
    }
}

impl Alternative {
    /// A new alternative, before any comparison.
    pub(super) fn new(particles: Particles, monitor: LostMonitor) -> Self {
        Alternative { particles, monitor, scans: 0, gain: 0.0 }
    }

    /// Whether both the monitor and the scans rate it clearly better than the tracked belief.
    fn is_better_than(&self, tracked: &LostMonitor) -> bool {
        let (own, rival) = (tracked.log_odds(), self.monitor.log_odds());
        own > 0.0 && own - rival > CLEARLY && self.gain > CLEARLY
    }

    /// Whether to replace the tracked belief. Where the map is poor, no pose is rated more likely
    /// right than wrong: then the alternative must be the better one for the maximum number of
    /// scans.
    fn replaces(&self, tracked: &LostMonitor) -> bool {
        let needed = if self.monitor.log_odds() < 0.0 { MIN_SCANS } else { MAX_SCANS };
        self.scans >= needed && self.is_better_than(tracked)
    }

    /// Whether to drop the alternative.
    fn is_refuted_by(&self, tracked: &LostMonitor) -> bool {
        let is_worse = self.scans >= MIN_SCANS && self.monitor.log_odds() > 0.0;
        self.scans >= MAX_SCANS || is_worse && !self.is_better_than(tracked)
    }
}

impl Belief {
    /// Particles where a scan fits anywhere in the map; `None` where no candidate fits, for a scan
    /// without usable beams, and without a search.
    pub(super) fn search_map(
        &mut self,
        map: &PreparedMap,
        scan: &impl Likelihood,
        endpoints: &Endpoints,
    ) -> Option<Elsewhere> {
        self.spread_over(&map.candidates(endpoints), SPREAD, map, scan)
    }

    /// Particles around some candidates, weighted by a scan; those of the filter are unchanged.
    pub(super) fn spread_over(
        &mut self,
        candidates: &Candidates,
        spread: Spread,
        map: &PreparedMap,
        scan: &impl Likelihood,
    ) -> Option<Elsewhere> {
        let poses = &candidates.poses;
        if poses.is_empty() {
            return None;
        }
        let count = self.max_particles.max(poses.len());
        let mut around: Vec<Pose2> = poses.iter().cycle().take(count).copied().collect();
        order_by_place(&mut around);
        let here = std::mem::replace(self.filter.particles_mut(), Particles::from_poses(around));
        let report = self.search_tempering.update(&mut self.filter, &spread, scan, count);
        self.shrink(self.max_particles);
        let particles = std::mem::replace(self.filter.particles_mut(), here);
        let volume = candidates.volume.unwrap_or_else(|| poses.len() as f64 * spread.volume());
        let log_evidence = report.log_evidence + (volume / (map.free_space.area() * TAU)).ln();
        Some(Elsewhere { particles, log_evidence })
    }

    /// Adds particles found by a search, with the probability of being there as their weight.
    pub(super) fn add_weighted(&mut self, elsewhere: &Particles, probability: f64) {
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

/// Standard deviations around a candidate of a search \[m, m, rad\], about the steps of its grid.
pub(super) const SPREAD: Spread = Spread([0.1, 0.1, 0.035]);

/// A normal distribution around a pose, by its standard deviations \[m, m, rad\].
#[derive(Debug, Clone, Copy)]
pub(super) struct Spread(pub(super) [f64; 3]);

impl Spread {
    pub(super) fn covariance(&self) -> Matrix3<f64> {
        Matrix3::from_diagonal(&self.0.map(|sigma| sigma * sigma).into())
    }

    /// The volume for which a candidate stands \[m^2 rad\].
    fn volume(&self) -> f64 {
        TAU.powf(1.5) * self.0.iter().product::<f64>()
    }
}

impl Transport for Spread {
    fn moved(&self, pose: Pose2, noise: [f64; 4]) -> Pose2 {
        let [x, y, theta] = self.0;
        Pose2::new(pose.x + x * noise[0], pose.y + y * noise[1], pose.theta + theta * noise[2])
    }
}

/// Particles around the candidates of a search.
pub(super) struct Elsewhere {
    /// The particles, with normalised weights.
    pub(super) particles: Particles,
    /// ln(mean likelihood of the scan over the whole map).
    pub(super) log_evidence: f64,
}

impl Candidates {
    /// The candidates that the monitor rates about as credible as the best one. People at 1 m
    /// around the robot resemble a closet, but in a real closet other beams would pass through
    /// walls. Of a continuum all are kept.
    fn credible(self, shift: impl FnMut(Pose2) -> f64) -> Self {
        if self.volume.is_some() {
            return self;
        }
        let shifts: Vec<f64> = self.poses.iter().copied().map(shift).collect();
        let min = shifts.iter().copied().fold(f64::INFINITY, f64::min);
        let pairs = self.poses.into_iter().zip(shifts);
        let credible = pairs.filter(|(_, shift)| *shift <= min + CREDIBLE);
        Candidates { poses: credible.map(|(candidate, _)| candidate).collect(), volume: None }
    }
}

/// Orders poses along a Z-order curve over position and heading, so that those of a region follow
/// each other. Low-variance resampling keeps the order, and so it keeps the share of each region to
/// within a particle (Gerber, Chopin and Whiteley, "Negative association, ordering and convergence
/// of resampling methods", 2019): of two places that look the same none dies by chance.
fn order_by_place(poses: &mut [Pose2]) {
    let left = poses.iter().map(|pose| pose.x).fold(f64::INFINITY, f64::min);
    let low = poses.iter().map(|pose| pose.y).fold(f64::INFINITY, f64::min);
    // The casts saturate.
    let key = |pose: &Pose2| {
        let [x, y] = [pose.x - left, pose.y - low].map(|along| (along / PLACE[0]) as u32);
        let theta = (pose.theta.rem_euclid(TAU) / PLACE[1]) as u32;
        let bits =
            |k: u32| [theta, y, x].iter().fold(0, |key, at| key << 1 | u64::from(at >> k & 1));
        (0..16).rev().fold(0_u64, |key, k| key << 3 | bits(k))
    };
    poses.sort_by_cached_key(key);
}

/// Sides of a cell of that curve \[m, rad\].
const PLACE: [f64; 2] = [0.25, 0.25];

/// How well a scan fits: its mean log-likelihood over some particles \[nats\].
pub(super) fn fit(scan: &impl Likelihood, particles: &Particles) -> f64 {
    let mut ratings = vec![0.0; particles.len()];
    scan.rate(particles.poses(), &mut ratings);
    let pairs = ratings.iter().zip(particles.weights()).filter(|(_, weight)| *weight > 0.0);
    pairs.map(|(rating, weight)| rating * weight).sum()
}
