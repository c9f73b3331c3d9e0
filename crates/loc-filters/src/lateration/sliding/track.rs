//! The way that odometry reports, as far back as it is needed.

use loc_core::motion::{Integration, VelocityNoise, dead_reckon};
use loc_core::{Gaussian, Pose2, Twist2};
use std::collections::VecDeque;

/// A velocity that holds from its stamp until the next one.
#[derive(Debug, Clone, Copy)]
struct Leg {
    stamp: f64,
    twist: Twist2,
    /// Where it begins in the frame of the odometry.
    at: Passed,
}

/// How far the robot had come at some time.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Passed {
    /// Its pose in the frame of the odometry.
    pub(super) pose: Pose2,
    /// The way driven \[m\].
    pub(super) way: f64,
    /// All turning, whichever way round \[rad\].
    pub(super) turned: f64,
}

/// Velocities in order of time, with the way that they add up to.
#[derive(Debug, Clone)]
pub(super) struct Track {
    legs: VecDeque<Leg>,
    integration: Integration,
}

impl Track {
    /// Standing still at `stamp` \[s\].
    pub(super) fn new(stamp: f64, integration: Integration) -> Self {
        let leg = Leg { stamp, twist: Twist2::ZERO, at: Passed::default() };
        Track { legs: VecDeque::from([leg]), integration }
    }

    /// The first time that is remembered \[s\].
    pub(super) fn start(&self) -> f64 {
        self.legs.front().map_or(f64::INFINITY, |leg| leg.stamp)
    }

    /// The last velocity's time \[s\].
    pub(super) fn end(&self) -> f64 {
        self.legs.back().map_or(f64::NEG_INFINITY, |leg| leg.stamp)
    }

    /// Puts a velocity where its time is, and moves all that comes after it.
    pub(super) fn insert(&mut self, stamp: f64, twist: Twist2) {
        // One from before the first belongs to the first.
        let stamp = stamp.max(self.start());
        let at = self.at(stamp);
        let place = self.legs.partition_point(|leg| leg.stamp <= stamp);
        self.legs.insert(place, Leg { stamp, twist, at });
        for k in place + 1..self.legs.len() {
            self.legs[k].at = self.legs[k - 1].after(self.legs[k].stamp, self.integration);
        }
    }

    /// How far the robot had come at a time \[s\].
    pub(super) fn at(&self, stamp: f64) -> Passed {
        let next = self.legs.partition_point(|leg| leg.stamp <= stamp);
        match self.legs.get(next.saturating_sub(1)) {
            Some(leg) => leg.after(stamp, self.integration),
            None => Passed::default(),
        }
    }

    /// A belief of one time carried to a later one.
    pub(super) fn carry(
        &self,
        mut belief: Gaussian<3>,
        from: f64,
        to: f64,
        noise: &VelocityNoise,
    ) -> Gaussian<3> {
        let first = self.legs.partition_point(|leg| leg.stamp <= from).saturating_sub(1);
        let mut now = from;
        for k in first..self.legs.len() {
            let until = self.legs.get(k + 1).map_or(to, |next| next.stamp.min(to));
            if until > now {
                let twist = self.legs[k].twist;
                belief = dead_reckon(&belief, twist, until - now, self.integration, noise);
                now = until;
            }
        }
        belief
    }

    /// Forgets velocities that no time from `stamp` \[s\] on needs.
    pub(super) fn forget_before(&mut self, stamp: f64) {
        while self.legs.get(1).is_some_and(|second| second.stamp <= stamp) {
            self.legs.pop_front();
        }
    }
}

impl Leg {
    /// How far the robot has come `stamp` \[s\] into this leg.
    fn after(&self, stamp: f64, integration: Integration) -> Passed {
        let dt = (stamp - self.stamp).max(0.0);
        Passed {
            pose: integration.step(self.at.pose, self.twist, dt),
            way: self.at.way + self.twist.speed() * dt,
            turned: self.at.turned + self.twist.omega.abs() * dt,
        }
    }
}
