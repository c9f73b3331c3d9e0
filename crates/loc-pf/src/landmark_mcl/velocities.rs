//! The velocities of the recent past, each holding until the next.

use loc_core::Twist2;
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
