//! The velocities since the particles were moved last, and the motion segments that they make up.

use crate::Result;
use crate::motion::VelocityStep;
use loc_core::motion::{Integration, VelocityNoise, dead_reckon};
use loc_core::{Gaussian, Twist2};
use nalgebra::Vector3;
use std::collections::VecDeque;

/// Stamped velocities in order of their stamps, each valid until the next.
#[derive(Debug, Clone, Default)]
pub(super) struct Velocities {
    known: VecDeque<(f64, Twist2)>,
}

/// A velocity and the time for which it is valid.
#[derive(Debug, Clone, Copy)]
pub(super) struct VelocityInterval {
    pub(super) twist: Twist2,
    /// Duration \[s\].
    pub(super) duration: f64,
    /// Whether a motion segment starts with it.
    pub(super) starts_segment: bool,
}

/// Whether a motion segment ends between velocities of these stamps \[s\]: at the first of every
/// second.
fn ends_segment(before: f64, stamp: f64) -> bool {
    before.floor() < stamp.floor()
}

impl Velocities {
    /// Adds a velocity that is valid from `stamp` \[s\] on, behind others of the same stamp.
    pub(super) fn insert(&mut self, stamp: f64, twist: Twist2) {
        let index = self.known.partition_point(|(other, _)| *other <= stamp);
        self.known.insert(index, (stamp, twist));
    }

    /// The velocities from one time to another \[s\]. Before the first velocity the robot stands
    /// still.
    pub(super) fn between(
        &self,
        from: f64,
        to: f64,
    ) -> impl Iterator<Item = VelocityInterval> + '_ {
        let starts = || self.known.iter().map(|(stamp, _)| *stamp);
        let ends = starts().skip(1).chain([f64::INFINITY]);
        let before = [f64::INFINITY].into_iter().chain(starts());
        let intervals = self.known.iter().zip(ends).zip(before);
        let intervals = intervals.map(move |(((start, twist), end), before)| VelocityInterval {
            twist: *twist,
            duration: end.min(to) - start.max(from),
            starts_segment: ends_segment(before, *start),
        });
        intervals.filter(|interval| interval.duration > 0.0)
    }

    /// The last end of a segment up to a time \[s\].
    pub(super) fn segment_end_before(&self, limit: f64) -> Option<f64> {
        let known = self.known.partition_point(|(stamp, _)| *stamp <= limit);
        let is_end = |&k: &usize| ends_segment(self.known[k - 1].0, self.known[k].0);
        (1..known).rev().find(is_end).map(|k| self.known[k].0)
    }

    /// Drops velocities without effect after `stamp` \[s\].
    pub(super) fn drop_before(&mut self, stamp: f64) {
        while self.known.get(1).is_some_and(|(next, _)| *next <= stamp) {
            self.known.pop_front();
        }
    }
}

/// Standard deviation of the heading at which a new segment begins \[rad\]. The length of a segment
/// is off by half its square, 0.5 %.
const MAX_HEADING_SIGMA: f64 = 0.1;

/// The motion segments of a drive, each a step along and across the heading at its start.
///
/// Velocities arrive far more often than observations. Those of a segment are combined to one
/// motion, normally distributed in the frame of its start (E6, E7), so that a particle needs one
/// draw for all of them. Where the uncertainty of the heading grows the motion is no longer normal,
/// and a new segment begins.
///
/// # Errors
/// [`loc_core::Error::OutOfRange`] where the drive is longer than any robot's.
pub(super) fn segments(
    drive: impl IntoIterator<Item = VelocityInterval>,
    integration: Integration,
    noise: &VelocityNoise,
) -> Result<Vec<VelocityStep>> {
    let start = Gaussian::certain(Vector3::zeros());
    let (mut segments, mut segment) = (Vec::new(), start);
    for interval in drive {
        if interval.starts_segment || segment.covariance.m33 > MAX_HEADING_SIGMA * MAX_HEADING_SIGMA
        {
            segments.push(std::mem::replace(&mut segment, start));
        }
        segment = dead_reckon(&segment, interval.twist, interval.duration, integration, noise);
    }
    segments.push(segment);
    segments.retain(|segment| *segment != start);
    segments.iter().map(step).collect()
}

/// Euler's rule over a time of 1 s takes a velocity for a displacement.
fn step(segment: &Gaussian<3>) -> Result<VelocityStep> {
    let displacement = Twist2::from_vector(&segment.mean);
    VelocityStep::with_covariance(displacement, 1.0, &segment.covariance, Integration::Euler)
}
