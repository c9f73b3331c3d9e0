//! The odometry as a function of time.

use loc_core::{Pose2, angle};

/// Poses of the odometry, with headings that run on beyond a full turn.
#[derive(Debug, Default)]
pub(super) struct Trace {
    stamps: Vec<f64>,
    poses: Vec<Pose2>,
}

/// No gap longer than this is bridged \[s\].
const LONGEST_GAP: f64 = 0.5;

impl Trace {
    pub(super) fn push(&mut self, stamp: f64, pose: Pose2) {
        let is_late = self.stamps.last().is_some_and(|last| stamp <= *last);
        if is_late || !stamp.is_finite() || !pose.is_finite() {
            return;
        }
        let before = self.poses.last().map_or(0.0, |last| last.theta);
        let theta = before + angle::difference(pose.theta, before);
        self.stamps.push(stamp);
        self.poses.push(Pose2 { theta, ..pose });
    }

    /// The pose at a time, between the two around it; `None` outside and in a gap.
    pub(super) fn pose(&self, stamp: f64) -> Option<Pose2> {
        let after = self.stamps.partition_point(|known| *known < stamp).max(1);
        let (from, to) = (*self.stamps.get(after - 1)?, *self.stamps.get(after)?);
        if stamp < from || to - from > LONGEST_GAP {
            return None;
        }
        let (first, second) = (self.poses[after - 1], self.poses[after]);
        let share = (stamp - from) / (to - from);
        let between = |a: f64, b: f64| a + share * (b - a);
        Some(Pose2 {
            x: between(first.x, second.x),
            y: between(first.y, second.y),
            theta: between(first.theta, second.theta),
        })
    }

    /// How far the odometry turns from one time to another \[rad\].
    pub(super) fn turn(&self, from: f64, to: f64) -> Option<f64> {
        Some(self.pose(to)?.theta - self.pose(from)?.theta)
    }

    /// The difference between the greatest and the least rate of turn in a time \[rad/s\]; `None`
    /// where the odometry does not cover it.
    pub(super) fn change_of_rate(&self, from: f64, to: f64) -> Option<f64> {
        /// Rates are means over this \[s\].
        const OVER: f64 = 0.1;
        let count = ((to - from) / OVER).floor() as usize;
        let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..count {
            let start = from + k as f64 * OVER;
            let rate = self.turn(start, start + OVER)? / OVER;
            (least, greatest) = (least.min(rate), greatest.max(rate));
        }
        (count > 0).then_some(greatest - least)
    }
}
