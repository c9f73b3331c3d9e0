//! Steps from a velocity, or from speed and steering angle, over a time, with noise of the control
//! (M4).

use super::{Displacement, Motion, Step, angle_sigma, bounded, move_all};
use crate::elementary::sin_cos;
use crate::{PosesMut, Result};
use loc_core::error::{in_range, non_negative};
use loc_core::kinematics::Ackermann;
use loc_core::motion::{Integration, VelocityNoise};
use loc_core::random::ChaCha8Rng;
use loc_core::{Gaussian, Twist2};
use nalgebra::{Matrix3, Vector3};

/// A velocity (vx, vy, omega) for a time `dt`, drawn from a normal distribution for every particle
/// and carried out by one of the integration rules (E2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VelocityStep {
    /// Mean of (vx dt, vy dt, omega dt) \[m, m, rad\].
    mean: Vector3<f64>,
    /// Lower triangular; times its transpose the covariance of (vx dt, vy dt, omega dt).
    factor: Matrix3<f64>,
    integration: Integration,
}

impl VelocityStep {
    /// A step with the error model k_d, k_theta, k_drift (E7).
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for noise that is negative, a velocity or a time that is not
    /// finite, a negative time.
    pub fn new(
        twist: Twist2,
        dt: f64,
        noise: &VelocityNoise,
        integration: Integration,
    ) -> Result<Self> {
        noise.check()?;
        non_negative("dt [s]", dt)?;
        VelocityStep::with_covariance(twist, dt, &noise.covariance(twist, dt), integration)
    }

    /// A step with any covariance S_u of the control (vx, vy, omega), 3 x 3.
    ///
    /// # Errors
    /// [`loc_core::Error::NotACovariance`] for a matrix that is none, and as
    /// [`new`](VelocityStep::new).
    pub fn with_covariance(
        twist: Twist2,
        dt: f64,
        covariance: &Matrix3<f64>,
        integration: Integration,
    ) -> Result<Self> {
        non_negative("dt [s]", dt)?;
        let control = Gaussian::new(twist.to_vector(), *covariance)?;
        let (mean, mut factor) = (control.mean * dt, control.factor() * dt);
        let what = "velocity, and its standard deviation, times dt [m] or [rad]";
        for &value in mean.iter().chain(factor.iter()) {
            bounded(what, value)?;
        }
        let sigma_turn = factor.row(2).norm();
        if sigma_turn > 0.0 {
            let share = angle_sigma(sigma_turn * sigma_turn) / sigma_turn;
            factor.row_mut(2).scale_mut(share.min(1.0));
        }
        Ok(VelocityStep { mean, factor, integration })
    }
}

/// Where a step of a given turn leads: straight along `direction` \[rad\], by `length` times the
/// distance travelled.
pub(super) trait ChordRule: Copy {
    fn chord(self, turn: f64) -> (f64, f64);
}

#[derive(Clone, Copy)]
pub(super) struct Euler;
#[derive(Clone, Copy)]
pub(super) struct Midpoint;
#[derive(Clone, Copy)]
pub(super) struct ExactArc;

impl ChordRule for Euler {
    #[inline(always)]
    fn chord(self, _: f64) -> (f64, f64) {
        (0.0, 1.0)
    }
}

impl ChordRule for Midpoint {
    #[inline(always)]
    fn chord(self, turn: f64) -> (f64, f64) {
        (0.5 * turn, 1.0)
    }
}

impl ChordRule for ExactArc {
    /// The chord of an arc has the direction of the midpoint rule; its length is
    /// `sin(turn / 2) / (turn / 2)` of the arc's.
    #[inline(always)]
    fn chord(self, turn: f64) -> (f64, f64) {
        let half = 0.5 * turn;
        let small = half.abs() < 1e-4;
        let divisor = if small { 1.0 } else { half };
        let quotient = sin_cos(half).0 / divisor;
        (half, if small { 1.0 - half * half / 6.0 } else { quotient })
    }
}

#[derive(Clone, Copy)]
struct Drawn<C> {
    step: VelocityStep,
    rule: C,
}

impl<C: ChordRule> Step for Drawn<C> {
    #[inline(always)]
    // ANCHOR: draw
    fn draw(self, [a, b, c]: [f64; 3]) -> Displacement {
        let (mean, l) = (self.step.mean, self.step.factor);
        let forward = mean.x + l.m11 * a;
        let sideways = mean.y + (l.m21 * a + l.m22 * b);
        let turn = mean.z + (l.m31 * a + l.m32 * b + l.m33 * c);
        let (direction, length) = self.rule.chord(turn);
        Displacement { direction, along: forward * length, across: sideways * length, turn }
    }
    // ANCHOR_END: draw
}

impl Motion for VelocityStep {
    fn sample(&self, poses: PosesMut<'_>, rng: &mut ChaCha8Rng) {
        let step = *self;
        match self.integration {
            Integration::Euler => move_all(Drawn { step, rule: Euler }, poses, rng),
            Integration::Midpoint => move_all(Drawn { step, rule: Midpoint }, poses, rng),
            Integration::ExactArc => move_all(Drawn { step, rule: ExactArc }, poses, rng),
        }
    }
}

/// Speed and steering angle of a car for a time `dt`, both drawn for every particle; the pose
/// is that of the rear axle, which drives the exact arc of [`Ackermann::twist`].
///
/// Noise that would steer further than [`SHARPEST`](AckermannStep::SHARPEST) is cut there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AckermannStep {
    /// Distance travelled by the rear axle and its standard deviation \[m\].
    way: [f64; 2],
    /// Steering angle and its standard deviation \[rad\].
    steering: [f64; 2],
    /// 1 / L \[1/m\].
    curvature: f64,
}

impl AckermannStep {
    /// Maximum angle of a front wheel \[rad\].
    pub const SHARPEST: f64 = 1.4;

    /// A step at `speed` \[m/s\] and `steering` \[rad\] for `dt` \[s\]; `sigmas` are their standard
    /// deviations.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for numbers that are not finite, negative deviations or
    /// time, more than 1e9 m, a steering angle beyond [`SHARPEST`](AckermannStep::SHARPEST).
    pub fn new(
        drive: &Ackermann,
        [speed, steering]: [f64; 2],
        sigmas: [f64; 2],
        dt: f64,
    ) -> Result<Self> {
        non_negative("dt [s]", dt)?;
        let sigma_speed = non_negative("sigma of the speed [m/s]", sigmas[0])?;
        let sigma_steering = non_negative("sigma of the steering angle [rad]", sigmas[1])?;
        in_range("steering angle [rad]", "an angle in [-1.4, 1.4]", steering, |angle| {
            angle.abs() <= Self::SHARPEST
        })?;
        Ok(AckermannStep {
            way: [
                bounded("speed times dt [m]", speed * dt)?,
                bounded("sigma of the speed times dt [m]", sigma_speed * dt)?,
            ],
            steering: [steering, angle_sigma(sigma_steering * sigma_steering)],
            curvature: 1.0 / drive.wheelbase(),
        })
    }
}

impl Step for AckermannStep {
    #[inline(always)]
    fn draw(self, noise: [f64; 3]) -> Displacement {
        const SHARPEST: f64 = AckermannStep::SHARPEST;
        let way = self.way[0] + self.way[1] * noise[0];
        let steering = self.steering[0] + self.steering[1] * noise[1];
        let steering = if steering < SHARPEST { steering } else { SHARPEST };
        let steering = if steering > -SHARPEST { steering } else { -SHARPEST };
        let (sin, cos) = sin_cos(steering);
        let turn = way * self.curvature * (sin / cos);
        let (direction, length) = ExactArc.chord(turn);
        Displacement { direction, along: way * length, across: 0.0, turn }
    }
}

impl Motion for AckermannStep {
    fn sample(&self, poses: PosesMut<'_>, rng: &mut ChaCha8Rng) {
        move_all(*self, poses, rng);
    }
}
