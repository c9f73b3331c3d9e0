//! A velocity for a time, with noise of the control (M4).

use super::Motion;
use super::step::{Displacement, Step, angle_sigma, bounded, move_all};
use crate::elementary::sin_cos;
use crate::{PosesMut, Result};
use loc_core::error::non_negative;
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

/// Where a step of a given turn leads: straight along `direction` \[rad\], by `length` times the way
/// driven.
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
