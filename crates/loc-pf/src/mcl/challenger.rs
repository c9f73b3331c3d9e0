//! A second belief beside the tracked one: the robot may be elsewhere.
//!
//! One scan proves little. Among people it may fit a false place better than the true one, and a
//! cloud that follows it is lost. So the places that a search finds far away do not enter the
//! cloud. They are a belief of their own, the challenger, which is moved and weighed as the first
//! one is. Two judges watch both over the next scans: the likelihood of the scans, and the monitor
//! of [`crate::confidence`], which asks how the map explains all beams at the pose that a belief
//! reports, above all whether beams end behind walls, which no crowd can feign. The challenger
//! takes over once both call it clearly better and the monitor calls the tracked belief more wrong
//! than right. What was tracked before then challenges in turn, for a while.

use super::Mcl;
use super::observation::{MountedScan, endpoints, select};
use super::recover::fit;
use super::step::Step;
use crate::confidence::LostMonitor;
use crate::recovery::Suspicion;
use crate::{Particles, Result};

/// A belief that competes with the tracked one.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Challenger {
    cloud: Particles,
    monitor: LostMonitor,
    /// Scans that it has taken in.
    scans: u32,
    /// How much better the scans fit there than at the tracked cloud, the one that led there left
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
    pub(super) fn new(cloud: Particles, monitor: LostMonitor) -> Self {
        Challenger { cloud, monitor, scans: 0, gain: 0.0 }
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
            self.exchange_clouds(&mut challenger);
            let weighed = self.weigh_challenger(step, scans);
            self.exchange_clouds(&mut challenger);
            weighed?;
            challenger.gain += self.gain(&challenger.cloud, scans)?;
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

    /// Moves and weighs the present cloud as the tracked one, with the beams that it expects.
    fn weigh_challenger(&mut self, step: &Step, scans: &[MountedScan<'_>]) -> Result<()> {
        let beams = scans.iter().map(|mounted| select(mounted.scan, &self.settings)).collect();
        let beams = self.familiar(step, scans, beams)?;
        let endpoints = self.agreeing(step, endpoints(scans, &beams, self.range_offset()));
        let scan = self.surroundings.observe(scans, &beams, &endpoints, &self.settings)?;
        self.belief.track_elsewhere(step, &scan);
        Ok(())
    }

    /// How much better scans fit at a cloud than at the tracked one \[nats\]. All beams count, those
    /// too that either would not expect.
    fn gain(&self, cloud: &Particles, scans: &[MountedScan<'_>]) -> Result<f64> {
        let beams: Vec<_> = scans.iter().map(|s| select(s.scan, &self.settings)).collect();
        let endpoints = endpoints(scans, &beams, self.range_offset());
        let scan = self.surroundings.observe(scans, &beams, &endpoints, &self.settings)?;
        let tracked = self.belief.filter.particles();
        Ok(fit(&scan, cloud) - fit(&scan, tracked))
    }

    /// Lets the monitor look at the pose that the challenger reports.
    fn judge(&mut self, challenger: &mut Challenger, scans: &[MountedScan<'_>]) {
        let Challenger { cloud, monitor, .. } = challenger;
        let pose = self.clusterer.estimate(cloud).belief.pose();
        let support = self.settings.lost.tolerance.support(cloud, pose);
        monitor.update(self.rater.rate(pose, scans), support);
        challenger.scans += 1;
    }

    /// Whom to believe, and whether to go on with the other one.
    fn decide(&mut self, mut challenger: Challenger) {
        if challenger.takes_over_from(&self.monitor) {
            self.exchange_clouds(&mut challenger);
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

    fn exchange_clouds(&mut self, challenger: &mut Challenger) {
        std::mem::swap(self.belief.filter.particles_mut(), &mut challenger.cloud);
    }
}
