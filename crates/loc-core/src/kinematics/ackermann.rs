//! Steered front wheels, as a car has them (E3).

use super::differential::refuse_sideways;
use crate::error::positive;
use crate::{Error, Result, Twist2};
use nalgebra::Matrix3x2;

/// A drive with steered front wheels, as the bicycle in its middle plane:
/// `omega = v tan(steering) / L`, with v taken at the rear axle.
///
/// The speed comes from the rear wheels (B1), the steering angle from a rotary encoder (B2).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Ackermann {
    wheelbase: f64,
}

impl Ackermann {
    /// A drive from the distance between its axles, L \[m\].
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless the distance is positive.
    pub fn new(wheelbase: f64) -> Result<Self> {
        Ok(Ackermann { wheelbase: positive("wheelbase [m]", wheelbase)? })
    }

    /// Distance between the axles \[m\].
    pub fn wheelbase(&self) -> f64 {
        self.wheelbase
    }

    /// The velocity of the rear axle from speed \[m/s\] and steering angle, positive to the left
    /// \[rad\].
    pub fn twist(&self, speed: f64, steering: f64) -> Twist2 {
        Twist2::forward(speed, speed * steering.tan() / self.wheelbase)
    }

    /// Derivative of (vx, vy, omega) over (speed, steering), 3 x 2.
    pub fn jacobian(&self, speed: f64, steering: f64) -> Matrix3x2<f64> {
        let tan = steering.tan();
        let by_steering = speed * (1.0 + tan * tan) / self.wheelbase;
        Matrix3x2::new(1.0, 0.0, 0.0, 0.0, tan / self.wheelbase, by_steering)
    }

    /// Speed \[m/s\] and steering angle \[rad\] that give a velocity.
    ///
    /// # Errors
    /// [`Error::ImpossibleMotion`] for a sideways speed, and for a turn on the spot.
    pub fn wheels(&self, twist: Twist2) -> Result<(f64, f64)> {
        refuse_sideways("Ackermann drive", twist)?;
        if twist.vx == 0.0 && twist.omega != 0.0 {
            let motion = format!("turn on the spot at {} rad/s", twist.omega);
            return Err(Error::ImpossibleMotion { drive: "Ackermann drive", motion });
        }
        if twist.vx == 0.0 {
            return Ok((0.0, 0.0));
        }
        Ok((twist.vx, (twist.omega * self.wheelbase / twist.vx).atan()))
    }

    /// Steering angles (left, right) of the two front wheels, `track` \[m\] apart, whose axes meet
    /// the rear axle's in one point when the middle plane is steered by `steering` \[rad\].
    pub fn front_wheel_angles(&self, steering: f64, track: f64) -> (f64, f64) {
        let (forward, inward) = (self.wheelbase * steering.sin(), 0.5 * track * steering.sin());
        let angle =
            |side: f64| (forward / (self.wheelbase * steering.cos() + side * inward)).atan();
        (angle(-1.0), angle(1.0))
    }
}
