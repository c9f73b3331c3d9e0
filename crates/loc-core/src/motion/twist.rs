//! Velocities in the plane.

use nalgebra::Vector3;

/// Velocity of a robot in its own frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Twist2 {
    /// Forward speed \[m/s\].
    pub vx: f64,
    /// Speed to the left \[m/s\]; 0 for drives that cannot slide sideways.
    pub vy: f64,
    /// Turn rate, counter-clockwise \[rad/s\].
    pub omega: f64,
}

impl Twist2 {
    /// Standing still.
    pub const ZERO: Twist2 = Twist2 { vx: 0.0, vy: 0.0, omega: 0.0 };

    /// A velocity from its three components \[m/s, m/s, rad/s\].
    pub fn new(vx: f64, vy: f64, omega: f64) -> Self {
        Twist2 { vx, vy, omega }
    }

    /// The velocity (v, omega) of a drive that cannot slide sideways \[m/s, rad/s\].
    pub fn forward(v: f64, omega: f64) -> Self {
        Twist2 { vx: v, vy: 0.0, omega }
    }

    /// Speed over ground, whatever its direction \[m/s\].
    pub fn speed(self) -> f64 {
        f64::hypot(self.vx, self.vy)
    }

    /// The vector (vx, vy, omega).
    pub fn to_vector(self) -> Vector3<f64> {
        Vector3::new(self.vx, self.vy, self.omega)
    }

    /// A velocity from the vector (vx, vy, omega).
    pub fn from_vector(v: &Vector3<f64>) -> Self {
        Twist2::new(v.x, v.y, v.z)
    }

    /// Whether all three numbers are finite.
    pub fn is_finite(self) -> bool {
        self.vx.is_finite() && self.vy.is_finite() && self.omega.is_finite()
    }
}
