//! The velocities since the particles were moved last, and the motion segments that they make up.

use crate::Result;
use crate::motion::VelocityStep;
use loc_core::motion::{Integration, VelocityNoise, dead_reckon};
use loc_core::{Gaussian, Twist2};
use nalgebra::Vector3;
use std::collections::VecDeque;

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

/// Standard deviation of the heading at which a new leg begins \[rad\]. The length of a leg is
/// off by half its square, 0.5 %.
const STRAIGHT: f64 = 0.1;

/// The motion segments (legs) of a drive, each a step along and across the heading at its start.
///
/// Odometry reports far more often than landmarks are observed. The velocities in between are
/// combined to one motion, normally distributed in the frame of its start (E6, E7); a particle then
/// needs one draw for all of them. Where the heading becomes too uncertain the motion is no longer
/// normal, and a new leg begins.
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
