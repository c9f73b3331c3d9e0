//! The cost of a sliding window: past ranges, carried by odometry, as a sum to minimise over the current
//! pose, scale and offset.

use crate::lateration::locate::{bias_reach, bias_rows};
use crate::lateration::minimize::{
    Minimum, OFFSET, Problem, Row, SCALE, Square, UNKNOWNS, Unknowns, minimize,
};
use crate::lateration::{BiasPrior, Loss, RangeBias};
use loc_core::motion::{Integration, VelocityNoise, dead_reckon};
use loc_core::{Gaussian, Pose2, Twist2, angle};
use nalgebra::{Cholesky, Const, Matrix2, Point2, Rotation2, SMatrix, Vector2, Vector3};
use std::collections::VecDeque;
use std::f64::consts::PI;

/// Where the heading stands among the unknowns.
pub(super) const HEADING: usize = 2;

/// A past distance, carried by odometry into the robot frame of now.
#[derive(Debug, Clone, Copy)]
pub(super) struct Carried {
    pub(super) landmark: Point2<f64>,
    pub(super) distance: f64,
    /// Standard deviation, that of the odometry since then included \[m\].
    pub(super) sigma: f64,
    /// The antenna then, in the robot's frame now \[m\].
    pub(super) antenna: Vector2<f64>,
    /// Standard deviation of the distance alone \[m\].
    pub(super) own_sigma: f64,
    /// The motion from then to the next distance, with the variances of its odometry.
    pub(super) segment: MotionSegment,
}

/// The motion between two distances, in the robot frame of now.
#[derive(Debug, Clone, Copy)]
pub(super) struct MotionSegment {
    /// The robot at its start \[m\].
    pub(super) start: Vector2<f64>,
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
    /// Scale and offset as older distances found them, with the factor of their covariance; it
    /// takes the place of `bias`.
    pub(super) remembered: Option<(Vector2<f64>, Cholesky<f64, Const<2>>)>,
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
        let from_landmark = Vector2::new(at[0], at[1]) + arm - range.landmark.coords;
        let distance = from_landmark.norm();
        let direction = from_landmark.try_normalize(0.0).unwrap_or_default();
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

    /// What is known of scale and offset.
    fn bias_rows(&self, at: &Unknowns, visit: &mut dyn FnMut(&Row)) {
        let Some((bias, factor)) = &self.remembered else {
            return bias_rows(&self.bias, at, visit);
        };
        let lower = factor.l();
        let off = Vector2::new(at[SCALE], at[OFFSET]) - bias;
        let whitened = lower.solve_lower_triangular(&off);
        let slopes = lower.solve_lower_triangular(&Matrix2::identity());
        let (Some(residuals), Some(slopes)) = (whitened, slopes) else { return };
        for k in 0..2 {
            let mut gradient = Unknowns::zeros();
            (gradient[SCALE], gradient[OFFSET]) = (slopes[(k, 0)], slopes[(k, 1)]);
            let residual = residuals[k];
            visit(&Row { residual, gradient, ..Row::like(1.0, Loss::Quadratic) });
        }
    }

    /// Direction of the distance's growth, in the robot's frame now.
    fn direction(range: &Carried, at: &Unknowns) -> Vector2<f64> {
        let turned = Rotation2::new(at[HEADING]);
        let offset = Vector2::new(at[0], at[1]) + turned * range.antenna - range.landmark.coords;
        turned.inverse() * offset.try_normalize(0.0).unwrap_or_default()
    }
}

impl Problem for Window {
    fn rows(&self, at: &Unknowns, visit: &mut dyn FnMut(&Row)) {
        self.ranges.iter().for_each(|range| visit(&self.row(range, at)));
        self.bias_rows(at, visit);
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

    /// An odometry error of one segment shifts all distances measured before it, and so does the
    /// error of a heading that is not estimated here.
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
            let MotionSegment { start: pivot, ahead, along, turn } = range.segment;
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

/// A velocity that holds from its stamp until the next one.
#[derive(Debug, Clone, Copy)]
struct VelocitySegment {
    stamp: f64,
    twist: Twist2,
    /// The motion up to its start.
    start: Travelled,
}

/// The accumulated motion of the odometry up to some time.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Travelled {
    /// Its pose in the frame of the odometry.
    pub(super) pose: Pose2,
    /// The distance travelled \[m\].
    pub(super) distance: f64,
    /// The sum of all absolute turns \[rad\].
    pub(super) turned: f64,
}

/// The odometry of the recent past: velocities in order of time, integrated to a path.
#[derive(Debug, Clone)]
pub(super) struct Track {
    segments: VecDeque<VelocitySegment>,
    integration: Integration,
}

impl Track {
    /// Standing still at `stamp` \[s\].
    pub(super) fn new(stamp: f64, integration: Integration) -> Self {
        let segment = VelocitySegment { stamp, twist: Twist2::ZERO, start: Travelled::default() };
        Track { segments: VecDeque::from([segment]), integration }
    }

    /// The first time that is remembered \[s\].
    pub(super) fn start(&self) -> f64 {
        self.segments.front().map_or(f64::INFINITY, |segment| segment.stamp)
    }

    /// The last velocity's time \[s\].
    pub(super) fn end(&self) -> f64 {
        self.segments.back().map_or(f64::NEG_INFINITY, |segment| segment.stamp)
    }

    /// Inserts a velocity by its stamp and integrates the later ones anew.
    pub(super) fn insert(&mut self, stamp: f64, twist: Twist2) {
        // One from before the first belongs to the first.
        let stamp = stamp.max(self.start());
        let start = self.at(stamp);
        let place = self.segments.partition_point(|segment| segment.stamp <= stamp);
        self.segments.insert(place, VelocitySegment { stamp, twist, start });
        for k in place + 1..self.segments.len() {
            self.segments[k].start =
                self.segments[k - 1].after(self.segments[k].stamp, self.integration);
        }
    }

    /// The motion up to a time \[s\].
    pub(super) fn at(&self, stamp: f64) -> Travelled {
        let next = self.segments.partition_point(|segment| segment.stamp <= stamp);
        match self.segments.get(next.saturating_sub(1)) {
            Some(segment) => segment.after(stamp, self.integration),
            None => Travelled::default(),
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
        let first =
            self.segments.partition_point(|segment| segment.stamp <= from).saturating_sub(1);
        let mut now = from;
        for k in first..self.segments.len() {
            let until = self.segments.get(k + 1).map_or(to, |next| next.stamp.min(to));
            if until > now {
                let twist = self.segments[k].twist;
                belief = dead_reckon(&belief, twist, until - now, self.integration, noise);
                now = until;
            }
        }
        belief
    }

    /// Drops velocities that no time from `stamp` \[s\] on needs.
    pub(super) fn forget_before(&mut self, stamp: f64) {
        while self.segments.get(1).is_some_and(|second| second.stamp <= stamp) {
            self.segments.pop_front();
        }
    }
}

impl VelocitySegment {
    /// The motion up to `stamp` \[s\], a time within this segment.
    fn after(&self, stamp: f64, integration: Integration) -> Travelled {
        let dt = (stamp - self.stamp).max(0.0);
        Travelled {
            pose: integration.step(self.start.pose, self.twist, dt),
            distance: self.start.distance + self.twist.speed() * dt,
            turned: self.start.turned + self.twist.omega.abs() * dt,
        }
    }
}
