//! Distances of the recent past as a sum to minimise over the pose now, scale and offset.

use crate::lateration::locate::{bias_reach, bias_rows};
use crate::lateration::minimize::{
    Minimum, OFFSET, Problem, Row, SCALE, Square, UNKNOWNS, Unknowns, minimize,
};
use crate::lateration::{BiasPrior, Loss, RangeBias};
use loc_core::motion::{Integration, VelocityNoise, dead_reckon};
use loc_core::{Gaussian, Pose2, Twist2, angle};
use nalgebra::{Cholesky, Const, Point2, Rotation2, SMatrix, Vector2, Vector3};
use std::collections::VecDeque;
use std::f64::consts::PI;

/// Where the heading stands among the unknowns.
pub(super) const HEADING: usize = 2;

/// A distance with where it was measured, seen from where the robot is now.
#[derive(Debug, Clone, Copy)]
pub(super) struct Carried {
    pub(super) landmark: Point2<f64>,
    pub(super) distance: f64,
    /// Standard deviation, the way since then included \[m\].
    pub(super) sigma: f64,
    /// The antenna then, in the robot's frame now \[m\].
    pub(super) antenna: Vector2<f64>,
    /// Standard deviation of the distance alone \[m\].
    pub(super) own_sigma: f64,
    /// How far odometry may be off from then to the next distance.
    pub(super) leg: Leg,
}

/// A piece of the way between two distances, seen from where the robot is now.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leg {
    /// The robot at its start \[m\].
    pub(super) at: Vector2<f64>,
    /// Its heading there, as a unit vector.
    pub(super) ahead: Vector2<f64>,
    /// Variance of its length \[m^2\].
    pub(super) along: f64,
    /// Variance of its turn \[rad^2\].
    pub(super) turn: f64,
}

/// The window's sum of squares.
pub(super) struct Window {
    pub(super) ranges: Vec<Carried>,
    pub(super) loss: Loss,
    pub(super) bias: BiasPrior,
    /// What else is known of the pose, with the factor of its covariance.
    pub(super) known: Option<(Vector3<f64>, Cholesky<f64, Const<3>>)>,
    /// The variance of a heading that is known from elsewhere \[rad^2\]; without, it is to be found.
    pub(super) heading: Option<f64>,
    /// Size of the whole figure \[m\].
    pub(super) extent: f64,
}

impl Window {
    /// The minimum that a pose leads to.
    pub(super) fn solve(&self, pose: Vector3<f64>) -> Option<Minimum> {
        let mut start = Unknowns::zeros();
        start.fixed_rows_mut::<3>(0).copy_from(&pose);
        start[SCALE] = 1.0;
        let mut found = minimize(self, start)?;
        let farthest = found.at.fixed_rows::<2>(0) - pose.fixed_rows::<2>(0);
        found.at[HEADING] = angle::wrap(found.at[HEADING]);
        (farthest.norm() <= 10.0 * self.extent).then_some(found)
    }

    /// Distance by distance: how many standard deviations it is off at a minimum.
    pub(super) fn deviation(&self, range: &Carried, at: &Unknowns) -> f64 {
        self.row(range, at).residual / range.sigma
    }

    fn row(&self, range: &Carried, at: &Unknowns) -> Row {
        let bias = RangeBias { scale: at[SCALE], offset: at[OFFSET] };
        let (sin, cos) = at[HEADING].sin_cos();
        let arm = Vector2::new(
            cos * range.antenna.x - sin * range.antenna.y,
            sin * range.antenna.x + cos * range.antenna.y,
        );
        let way = Vector2::new(at[0], at[1]) + arm - range.landmark.coords;
        let distance = way.norm();
        let direction = way.try_normalize(0.0).unwrap_or_default();
        let by_heading = direction.y * arm.x - direction.x * arm.y;
        let gradient = Unknowns::from([
            bias.scale * direction.x,
            bias.scale * direction.y,
            bias.scale * by_heading,
            distance,
            1.0,
        ]);
        let residual = bias.reported(distance) - range.distance;
        let own_variance = range.own_sigma * range.own_sigma;
        Row { residual, gradient, own_variance, ..Row::like(range.sigma, self.loss) }
    }

    /// Direction of the distance's growth, in the robot's frame now.
    fn direction(range: &Carried, at: &Unknowns) -> Vector2<f64> {
        let turned = Rotation2::new(at[HEADING]);
        let way = Vector2::new(at[0], at[1]) + turned * range.antenna - range.landmark.coords;
        turned.inverse() * way.try_normalize(0.0).unwrap_or_default()
    }
}

impl Problem for Window {
    fn rows(&self, at: &Unknowns, visit: &mut dyn FnMut(&Row)) {
        self.ranges.iter().for_each(|range| visit(&self.row(range, at)));
        bias_rows(&self.bias, at, visit);
        let Some((pose, factor)) = &self.known else { return };
        let mut off = Vector3::new(at[0], at[1], at[2]) - pose;
        off.z = angle::wrap(off.z);
        let lower = factor.l_dirty();
        let Some(whitened) = lower.solve_lower_triangular(&off) else { return };
        let Some(slopes) = lower.solve_lower_triangular(&nalgebra::Matrix3::identity()) else {
            return;
        };
        for k in 0..3 {
            let mut gradient = Unknowns::zeros();
            gradient.fixed_rows_mut::<3>(0).copy_from(&slopes.row(k).transpose());
            let residual = whitened[k];
            visit(&Row { residual, gradient, ..Row::like(1.0, Loss::Quadratic) });
        }
    }

    /// An error of odometry on one leg moves all that was measured before it, and so does one of a
    /// heading that is not found here.
    fn shared_noise(&self, at: &Unknowns) -> Square {
        let mut noise = Square::zeros();
        let mut by_heading = Unknowns::zeros();
        // Of all distances so far: how the gradient answers to a shift, and to a turn about 0.
        let mut by_shift = SMatrix::<f64, UNKNOWNS, 2>::zeros();
        let mut by_turn = Unknowns::zeros();
        for range in &self.ranges {
            let Row { residual, gradient, sigma, loss, .. } = self.row(range, at);
            let direction = Window::direction(range, at) * at[SCALE];
            let weighted = gradient * (loss.weight(residual / sigma) / (sigma * sigma));
            by_shift += weighted * direction.transpose();
            by_heading += weighted * gradient[HEADING];
            by_turn += weighted * direction.dot(&across(range.antenna));
            let Leg { at: pivot, ahead, along, turn } = range.leg;
            let shifted = by_shift * ahead;
            let turned = by_turn - by_shift * across(pivot);
            noise.ger(along, &shifted, &shifted, 1.0);
            noise.ger(turn, &turned, &turned, 1.0);
        }
        noise.ger(self.heading.unwrap_or(0.0), &by_heading, &by_heading, 1.0);
        noise
    }

    fn reach(&self) -> Unknowns {
        let heading = if self.heading.is_none() { PI } else { 0.0 };
        let mut reach = Unknowns::from([self.extent, self.extent, heading, 0.0, 0.0]);
        bias_reach(&self.bias, self.extent, &mut reach);
        reach
    }
}

/// A vector turned left by a right angle.
fn across(vector: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-vector.y, vector.x)
}

/// The pose among the unknowns, as a belief.
pub(super) fn pose_of(minimum: &Minimum) -> Gaussian<3> {
    Gaussian {
        mean: minimum.at.fixed_rows::<3>(0).into(),
        covariance: minimum.covariance.fixed_view::<3, 3>(0, 0).into(),
    }
}

// The way that odometry reports, as far back as it is needed.

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
