//! The recent past: what came late is taken in where it belongs.
//!
//! LandmarkObservations are remembered with the filter as it was before them. A late input takes the filter
//! back there, and what came after it is taken in again, with the same random numbers.

use super::{LandmarkMcl, State};
use crate::motion::VelocityStep;
use crate::{Error, Particles, Result};
use loc_core::error::finite;
use loc_core::motion::{Integration, VelocityNoise, dead_reckon};
use loc_core::random::ChaCha8Rng;
use loc_core::{Gaussian, Twist2};
use loc_sensors::landmark_camera::LandmarkObservation;
use nalgebra::Vector3;
use std::collections::VecDeque;

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

// The velocities of the recent past, each holding until the next.

/// Stamped velocities in order of their stamps.
#[derive(Debug, Clone, Default)]
pub(super) struct Velocities {
    known: VecDeque<(f64, Twist2)>,
}

/// A velocity and how long it held.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hold {
    pub(super) twist: Twist2,
    /// How long \[s\].
    pub(super) duration: f64,
    /// Whether a leg ends where it began to hold.
    pub(super) starts_leg: bool,
}

/// Whether a leg ends between velocities of these stamps \[s\]: at the first of every second.
fn leg_ends(before: f64, stamp: f64) -> bool {
    before.floor() < stamp.floor()
}

impl Velocities {
    /// Adds a velocity that holds from `stamp` \[s\] on, behind others of the same stamp.
    pub(super) fn insert(&mut self, stamp: f64, twist: Twist2) {
        let place = self.known.partition_point(|(other, _)| *other <= stamp);
        self.known.insert(place, (stamp, twist));
    }

    /// Stamp of the newest one \[s\].
    pub(super) fn newest(&self) -> Option<f64> {
        self.known.back().map(|(stamp, _)| *stamp)
    }

    /// What held from one time to another \[s\]. Before the first velocity the robot stood still.
    pub(super) fn between(&self, from: f64, to: f64) -> impl Iterator<Item = Hold> + '_ {
        let starts = || self.known.iter().map(|(stamp, _)| *stamp);
        let ends = starts().skip(1).chain([f64::INFINITY]);
        let before = [f64::INFINITY].into_iter().chain(starts());
        let holds = self.known.iter().zip(ends).zip(before);
        let holds = holds.map(move |(((start, twist), end), before)| Hold {
            twist: *twist,
            duration: end.min(to) - start.max(from),
            starts_leg: leg_ends(before, *start),
        });
        holds.filter(|hold| hold.duration > 0.0)
    }

    /// The last end of a leg up to a time \[s\].
    pub(super) fn leg_end_before(&self, limit: f64) -> Option<f64> {
        let known = self.known.partition_point(|(stamp, _)| *stamp <= limit);
        let is_end = |&k: &usize| leg_ends(self.known[k - 1].0, self.known[k].0);
        (1..known).rev().find(is_end).map(|k| self.known[k].0)
    }

    /// Forgets what has no effect after `stamp` \[s\].
    pub(super) fn forget_before(&mut self, stamp: f64) {
        while self.known.get(1).is_some_and(|(next, _)| *next <= stamp) {
            self.known.pop_front();
        }
    }
}

// A stretch of the drive between two observations, drawn at once.
//
// Odometry speaks far more often than landmarks are seen. The velocities in between are put
// together to one motion, normally distributed in the frame of its start (E6, E7); a particle then
// needs one draw for all of them. Where the heading becomes unsure the motion is no longer normal
// (it bends like a banana), and a new leg begins.

/// Standard deviation of the heading at which a new leg begins \[rad\]. The length of a leg is
/// off by half its square, 0.5 %.
const STRAIGHT: f64 = 0.1;

/// The legs of a drive, each a step along and across the heading at its start.
///
/// # Errors
/// [`loc_core::Error::OutOfRange`] where the drive is longer than any robot's.
pub(super) fn legs(
    drive: impl IntoIterator<Item = Hold>,
    integration: Integration,
    noise: &VelocityNoise,
) -> Result<Vec<VelocityStep>> {
    let start = Gaussian::certain(Vector3::zeros());
    let (mut legs, mut leg) = (Vec::new(), start);
    for hold in drive {
        if hold.starts_leg || leg.covariance.m33 > STRAIGHT * STRAIGHT {
            legs.push(std::mem::replace(&mut leg, start));
        }
        leg = dead_reckon(&leg, hold.twist, hold.duration, integration, noise);
    }
    legs.push(leg);
    legs.retain(|leg| *leg != start);
    legs.iter().map(step).collect()
}

/// Euler's rule over a time of 1 s takes a velocity for a displacement.
fn step(leg: &Gaussian<3>) -> Result<VelocityStep> {
    let displacement = Twist2::from_vector(&leg.mean);
    VelocityStep::with_covariance(displacement, 1.0, &leg.covariance, Integration::Euler)
}
