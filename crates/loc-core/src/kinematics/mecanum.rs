//! Four wheels with rollers at 45 degrees: omnidirectional (E4).

use crate::error::positive;
use crate::{Result, Twist2};
use nalgebra::{Matrix3x4, Matrix4x3, Vector4};

/// A Mecanum drive with its rollers in X arrangement, seen from above.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Mecanum {
    lever: f64,
}

/// Rim speeds of the four wheels \[m/s\].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MecanumWheels {
    /// Front left.
    pub front_left: f64,
    /// Front right.
    pub front_right: f64,
    /// Rear left.
    pub rear_left: f64,
    /// Rear right.
    pub rear_right: f64,
}

impl MecanumWheels {
    /// The vector (front left, front right, rear left, rear right).
    pub fn to_vector(self) -> Vector4<f64> {
        Vector4::new(self.front_left, self.front_right, self.rear_left, self.rear_right)
    }
}

impl Mecanum {
    /// A drive from the distances between its axles and between its left and right wheels \[m\].
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] unless both are positive.
    pub fn new(wheelbase: f64, track: f64) -> Result<Self> {
        let wheelbase = positive("wheelbase [m]", wheelbase)?;
        let track = positive("wheel track [m]", track)?;
        Ok(Mecanum { lever: 0.5 * (wheelbase + track) })
    }

    /// The robot's velocity from its four rim speeds, by least squares where they contradict each
    /// other.
    pub fn twist(&self, wheels: MecanumWheels) -> Twist2 {
        Twist2::from_vector(&(self.jacobian() * wheels.to_vector()))
    }

    /// Derivative of (vx, vy, omega) over the rim speeds in the order of
    /// [`MecanumWheels::to_vector`], 3 x 4.
    pub fn jacobian(&self) -> Matrix3x4<f64> {
        let turn = 1.0 / self.lever;
        0.25 * Matrix3x4::new(
            1.0, 1.0, 1.0, 1.0, //
            -1.0, 1.0, 1.0, -1.0, //
            -turn, turn, -turn, turn,
        )
    }

    /// The rim speeds that give a velocity; every velocity is possible.
    pub fn wheels(&self, twist: Twist2) -> MecanumWheels {
        let a = self.lever;
        let by_twist = Matrix4x3::new(1.0, -1.0, -a, 1.0, 1.0, a, 1.0, 1.0, -a, 1.0, -1.0, a);
        let w = by_twist * twist.to_vector();
        MecanumWheels { front_left: w[0], front_right: w[1], rear_left: w[2], rear_right: w[3] }
    }

    /// How far four rim speeds contradict each other \[m/s\]: the speed at which the rollers must
    /// slip. 0 for wheels that roll freely.
    pub fn slip(&self, wheels: MecanumWheels) -> f64 {
        let w = wheels;
        0.5 * (w.front_left + w.front_right - w.rear_left - w.rear_right)
    }
}
