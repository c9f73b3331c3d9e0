//! The walls that a scan shows, and how far a laser has turned from one scan to the next.

use loc_core::{Pose2, angle};
use loc_sensors::laser::{Beam, LaserScan};
use nalgebra::{Matrix3, Point2, Vector2, Vector3};
use std::f64::consts::PI;

/// The ends of the beams of a scan in the laser's frame, by their bearings.
#[derive(Debug)]
pub(super) struct Outline {
    points: Vec<OutlinePoint>,
}

#[derive(Debug)]
struct OutlinePoint {
    bearing: f64,
    end: Point2<f64>,
    /// Of the wall through it, where its neighbours lie on one.
    normal: Option<Vector2<f64>>,
}

/// Points of two scans belong together within this at first, and at the end \[m\].
const REACH: [f64; 2] = [0.3, 0.1];

/// Standard deviation of a point from its wall \[m\].
const NOISE: f64 = 0.03;

/// Minimum number of points for a turn.
const MIN_POINTS: usize = 20;

/// Steps of the iteration, and a step that ends it \[m or rad\].
const STEPS: usize = 20;
const CLOSE: f64 = 1e-5;

impl Outline {
    /// At most `max` of the beams with a return.
    pub(super) fn of(scan: &LaserScan, max: usize) -> Self {
        let returned = |beam: &Beam| beam.range < scan.range_max;
        let beams: Vec<Beam> = scan.thinned(max).into_iter().filter(returned).collect();
        let ends: Vec<_> = beams.iter().map(|beam| beam.point()).collect();
        let normal = |k: usize| {
            let (before, after) = (k.checked_sub(1)?, k + 1);
            let along = ends.get(after)? - ends[before];
            let spread = angle::difference(beams[after].angle, beams[before].angle).abs();
            // Neighbours on a wall that is seen at up to about 70 degrees.
            let is_wall = along.norm() <= 3.0 * spread * beams[k].range + 0.05;
            (is_wall && along.norm() > 1e-6).then(|| Vector2::new(-along.y, along.x) / along.norm())
        };
        let point = |k: usize| OutlinePoint {
            bearing: angle::wrap(beams[k].angle),
            end: ends[k],
            normal: normal(k),
        };
        let mut points: Vec<_> = (0..beams.len()).map(point).collect();
        points.sort_by(|a, b| a.bearing.total_cmp(&b.bearing));
        Outline { points }
    }

    /// How far the laser has turned since an earlier scan \[rad\], from a guess of its motion:
    /// points are brought to the walls of the earlier scan, by weighted min squares of their
    /// distances from them (A. Censi, "An ICP variant using a point-to-line metric", 2008). `None`
    /// where the two do not fit, or do not determine a turn.
    pub(super) fn turn_since(&self, earlier: &Outline, guess: Pose2) -> Option<f64> {
        let mut motion = guess;
        let mut reach = REACH[0];
        for _ in 0..STEPS {
            let (information, gradient) = self.normal_equations(earlier, motion, reach)?;
            let step = -(information.cholesky()?.solve(&gradient));
            motion = Pose2::from_vector(&(motion.to_vector() + step));
            reach = (0.8 * reach).max(REACH[1]);
            if step.amax() < CLOSE && reach <= REACH[1] {
                break;
            }
        }
        let (information, _) = self.normal_equations(earlier, motion, REACH[1])?;
        let variance = information.try_inverse()?.m33 * NOISE * NOISE;
        let turned = angle::wrap(motion.theta);
        (turned.is_finite() && variance < 1e-4).then_some(turned)
    }

    fn normal_equations(
        &self,
        earlier: &Outline,
        motion: Pose2,
        reach: f64,
    ) -> Option<(Matrix3<f64>, Vector3<f64>)> {
        // Where walls do not determine a direction, the guess stays.
        let mut information = Matrix3::from_diagonal(&Vector3::new(1e-3, 1e-3, 1e-6));
        let (mut gradient, mut count) = (Vector3::zeros(), 0);
        for point in &self.points {
            let end = motion.transform(&point.end);
            let Some((wall, normal)) = earlier.nearest(&end, reach) else { continue };
            let residual = (end - wall).dot(&normal);
            let arm = end - motion.position();
            let jacobian = Vector3::new(normal.x, normal.y, normal.y * arm.x - normal.x * arm.y);
            let weight = 1.0 / (1.0 + (residual / NOISE).powi(2));
            information += weight * jacobian * jacobian.transpose();
            gradient += weight * residual * jacobian;
            count += 1;
        }
        (count >= MIN_POINTS).then_some((information, gradient))
    }

    /// The point on a wall nearest to another within a reach, with its normal: it lies within the
    /// angle under which the reach is seen.
    fn nearest(&self, end: &Point2<f64>, reach: f64) -> Option<(Point2<f64>, Vector2<f64>)> {
        let (range, bearing) = (end.coords.norm(), end.y.atan2(end.x));
        let window = if reach < range { (reach / range).asin() } else { PI };
        let first = self.points.partition_point(|point| point.bearing < bearing - window);
        let (count, mut best) = (self.points.len(), None);
        let mut min = reach * reach;
        let mut look = |point: &OutlinePoint| {
            let squared = (point.end - end).norm_squared();
            if let Some(normal) = point.normal.filter(|_| squared < min) {
                min = squared;
                best = Some((point.end, normal));
            }
        };
        let within = |point: &&OutlinePoint| (point.bearing - bearing).abs() <= window;
        self.points[first.min(count)..].iter().take_while(within).for_each(&mut look);
        // Across the back of the laser, where bearings start again.
        if bearing - window < -PI {
            let behind = |point: &&OutlinePoint| point.bearing - 2.0 * PI >= bearing - window;
            self.points.iter().rev().take_while(behind).for_each(&mut look);
        }
        if bearing + window > PI {
            let behind = |point: &&OutlinePoint| point.bearing + 2.0 * PI <= bearing + window;
            self.points.iter().take_while(behind).for_each(&mut look);
        }
        best
    }
}

/// The odometry as a function of time: poses with unwrapped headings.
#[derive(Debug, Default)]
pub(super) struct Trace {
    stamps: Vec<f64>,
    poses: Vec<Pose2>,
}

/// Maximum gap that is interpolated \[s\].
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

    /// The difference between the maximum and the minimum rate of turn in a time \[rad/s\]; `None`
    /// where the odometry does not cover it.
    pub(super) fn change_of_rate(&self, from: f64, to: f64) -> Option<f64> {
        /// Rates are means over this \[s\].
        const OVER: f64 = 0.1;
        let count = ((to - from) / OVER).floor() as usize;
        let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..count {
            let start = from + k as f64 * OVER;
            let rate = self.turn(start, start + OVER)? / OVER;
            (min, max) = (min.min(rate), max.max(rate));
        }
        (count > 0).then_some(max - min)
    }
}
