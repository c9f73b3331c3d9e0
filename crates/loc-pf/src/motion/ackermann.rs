//! A car: speed and steering angle for a time, with noise on both.

use super::Motion;
use super::step::{Displacement, Step, angle_sigma, bounded, move_all};
use super::velocity::{ChordRule, ExactArc};
use crate::elementary::sin_cos;
use crate::{PosesMut, Result};
use loc_core::error::{in_range, non_negative};
use loc_core::kinematics::Ackermann;
use loc_core::random::ChaCha8Rng;

/// Speed and steering angle of a car for a time `dt`, both drawn anew for every particle; the pose
/// is that of the rear axle, which drives the exact arc of [`Ackermann::twist`].
///
/// Noise that would steer further than [`SHARPEST`](AckermannStep::SHARPEST) is cut there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AckermannStep {
    /// Way of the rear axle and its standard deviation \[m\].
    way: [f64; 2],
    /// Steering angle and its standard deviation \[rad\].
    steering: [f64; 2],
    /// 1 / L \[1/m\].
    curvature: f64,
}

impl AckermannStep {
    /// No front wheel turns further than this \[rad\].
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
