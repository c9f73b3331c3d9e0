//! The recent past: what came late is taken in where it belongs.
//!
//! LandmarkObservations are remembered with the filter as it was before them. A late input takes the filter
//! back there, and what came after it is taken in again, with the same random numbers.

use super::{LandmarkMcl, State};
use crate::{Error, Particles, Result};
use loc_core::error::finite;
use loc_core::random::ChaCha8Rng;
use loc_sensors::landmark_camera::LandmarkObservation;

/// The filter as it was at some time.
#[derive(Debug)]
pub(super) struct Snapshot {
    pub(super) state: State,
    particles: Particles,
    rng: ChaCha8Rng,
}

/// LandmarkObservations, and the filter as it was before them.
#[derive(Debug)]
pub(super) struct Moment {
    pub(super) stamp: f64,
    pub(super) observations: Vec<LandmarkObservation>,
    pub(super) before: Snapshot,
}

impl LandmarkMcl {
    /// Time of the newest input \[s\]; `None` before the first.
    pub(super) fn newest(&self) -> Option<f64> {
        let observations = self.past.back().map(|moment| moment.stamp);
        let newest = [self.velocities.newest(), observations].into_iter().flatten();
        newest.reduce(f64::max)
    }

    pub(super) fn check_stamp(&self, what: &'static str, stamp: f64) -> Result<()> {
        finite("stamp [s]", stamp)?;
        let horizon = self.settings.horizon;
        match self.newest() {
            Some(newest) if stamp < newest - horizon => {
                Err(Error::TooLate { what, stamp, newest, horizon })
            }
            _ => Ok(()),
        }
    }

    /// Index of the first remembered observations after a time.
    pub(super) fn place_after(&self, stamp: f64) -> usize {
        self.past.partition_point(|moment| moment.stamp <= stamp)
    }

    pub(super) fn snapshot(&mut self) -> Snapshot {
        let particles = self.filter.particles().clone();
        Snapshot { state: self.state, particles, rng: self.filter.rng_mut().clone() }
    }

    pub(super) fn go_back_to(&mut self, place: usize) {
        if let Some(Moment { before, .. }) = self.past.get(place) {
            self.state = before.state;
            self.filter.particles_mut().clone_from(&before.particles);
            self.filter.rng_mut().clone_from(&before.rng);
        }
    }

    /// Takes in again, from where the filter stands, the observations from index `place` on.
    pub(super) fn repeat_from(&mut self, place: usize) -> Result<()> {
        for place in place..self.past.len() {
            let before = self.snapshot();
            let observations = std::mem::take(&mut self.past[place].observations);
            let stamp = self.past[place].stamp;
            self.take_in(stamp, &observations)?;
            self.past[place] = Moment { stamp, observations, before };
        }
        Ok(())
    }

    /// Forgets what no input can reach any more.
    pub(super) fn forget(&mut self) {
        let Some(limit) = self.newest().map(|newest| newest - self.settings.horizon) else {
            return;
        };
        // The newest moment stays, so that there is always a last stamp to compare with.
        while self.past.len() > 1 && self.past[0].stamp < limit {
            self.past.pop_front();
        }
        if let Some(stamp) = self.velocities.leg_end_before(limit) {
            self.drive_to(stamp);
        }
        let oldest = self.past.front().map_or(self.state.stamp, |moment| moment.before.state.stamp);
        self.velocities.forget_before(oldest);
    }
}
