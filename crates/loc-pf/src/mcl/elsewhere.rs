//! Where else the robot may be, when the tracked belief is suspected.

use super::Mcl;
use super::challenger::{CLEARLY, Challenger};
use super::observation::{MountedScan, endpoints, select};
use super::recover::{SPREAD, Spread, fit};
use crate::confidence::{LostMonitor, Tolerance};
use crate::recovery::Suspicion;
use crate::{Particles, Result};
use loc_core::Pose2;

/// Places are looked at if the scan makes them at most this much less credible than the best one
/// \[nats\].
const CREDIBLE: f64 = 1.0;

/// The share of the cloud that goes to a place beside it.
const SHIFTED: f64 = 0.95;

/// What a look around found.
enum Found {
    /// The robot beside the reported pose.
    Beside(Particles),
    /// Another place of the map.
    Elsewhere(Particles),
    Nothing,
}

impl Mcl {
    /// Looks for the robot where it is not tracked. What is found beside the reported pose goes into
    /// the cloud; another place makes a challenger.
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
            Found::Elsewhere(cloud) => {
                Ok(Some(Challenger::new(cloud, LostMonitor::new(self.settings.lost)?)))
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
            && fit(&scan, &beside.cloud) > here + CLEARLY
        {
            let pose = clusterer.estimate(&beside.cloud).belief.pose();
            if pose.distance(reported) < 2.0 * distance && shift(pose) < shift(reported).min(0.0) {
                return Ok(Found::Beside(beside.cloud));
            }
        }
        let places = credible(surroundings.places(&endpoints), shift);
        let found = belief.spread_over(&places, SPREAD, surroundings, &scan);
        let found = found.filter(|found| fit(&scan, &found.cloud) > here);
        Ok(found.map_or(Found::Nothing, |found| Found::Elsewhere(found.cloud)))
    }

    /// Nothing came of a search. The next one waits, unless the robot is lost in any case.
    pub(super) fn searched_in_vain(&mut self) {
        let is_lost = self.monitor.probability() > 0.5;
        self.belief.suspicion.iter_mut().for_each(|suspicion| suspicion.put_off(is_lost));
    }
}

/// The places at which the monitor finds the scans about as credible as at the best one. People
/// at 1 m around the robot look like a closet; but there other beams would go through walls.
fn credible(places: Vec<Pose2>, shift: impl FnMut(Pose2) -> f64) -> Vec<Pose2> {
    let shifts: Vec<f64> = places.iter().copied().map(shift).collect();
    let least = shifts.iter().copied().fold(f64::INFINITY, f64::min);
    let pairs = places.into_iter().zip(shifts);
    pairs.filter(|(_, shift)| *shift <= least + CREDIBLE).map(|(place, _)| place).collect()
}
