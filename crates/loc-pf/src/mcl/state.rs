//! The state of the filter, to be kept over a restart of the robot.

use super::recovery::Alternative;
use super::standing::Standing;
use super::{Mcl, MotionModel, RangeOffsetEstimate, ScanModel};
use crate::confidence::LostMonitor;
use crate::motion::DrivenPath;
use crate::recovery::{AugmentedMcl, Suspicion};
use crate::{Error, Particles, Result};
use loc_core::Gaussian;
use loc_core::random::ChaCha8Rng;

/// The state of an [`Mcl`], to be kept over a restart of the robot: particles, random generator,
/// averages, and the path since the last update. Map and settings are not part of it.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MclState {
    particles: Particles,
    rng: ChaCha8Rng,
    path: Option<DrivenPath>,
    start: Option<Gaussian<3>>,
    has_seen: bool,
    is_anywhere: bool,
    updates_since_resampling: usize,
    suspicion: Option<Suspicion>,
    augmented: Option<AugmentedMcl>,
    monitor: LostMonitor,
    alternative: Option<Alternative>,
    offset: RangeOffsetEstimate,
    standing: Standing,
    off_map: u32,
}

impl<M: MotionModel, S: ScanModel> Mcl<M, S> {
    /// The state of the filter; [`restore`](Mcl::restore) continues from it, to the bit.
    pub fn state(&self) -> MclState {
        let belief = &self.belief;
        MclState {
            particles: belief.filter.particles().clone(),
            rng: belief.filter.rng().clone(),
            path: self.path,
            start: self.start,
            has_seen: belief.has_seen,
            is_anywhere: belief.is_anywhere,
            updates_since_resampling: belief.updates_since_resampling,
            suspicion: belief.suspicion,
            augmented: belief.augmented,
            monitor: self.monitor,
            alternative: self.alternative.clone(),
            offset: self.offset,
            standing: self.standing,
            off_map: self.off_map,
        }
    }

    /// Continues from the state of another filter with the same map and settings.
    ///
    /// # Errors
    /// [`loc_core::Error::Length`] for a state without particles, and
    /// [`loc_core::Error::OutOfRange`] for one with poses that are not finite.
    pub fn restore(&mut self, state: MclState) -> Result<()> {
        state.particles.check()?;
        if state.particles.is_empty() {
            let (what, expected) = ("particles of a saved state", "at least 1");
            return Err(Error::Core(loc_core::Error::Length { what, expected, found: 0 }));
        }
        let belief = &mut self.belief;
        *belief.filter.particles_mut() = state.particles;
        *belief.filter.rng_mut() = state.rng;
        (self.path, self.start) = (state.path, state.start);
        belief.has_seen = state.has_seen;
        belief.is_anywhere = state.is_anywhere;
        belief.updates_since_resampling = state.updates_since_resampling;
        (belief.suspicion, belief.augmented) = (state.suspicion, state.augmented);
        self.monitor = state.monitor;
        (self.alternative, self.offset) = (state.alternative, state.offset);
        (self.standing, self.off_map) = (state.standing, state.off_map);
        self.cluster();
        Ok(())
    }
}
