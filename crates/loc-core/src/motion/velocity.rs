//! Motion at constant velocity: a velocity, its integration over one time step (E2), its noise (E7)
//! and dead reckoning with its growing covariance (E6).

use crate::error::non_negative;
use crate::{Gaussian, Pose2, Result};
use nalgebra::{Matrix3, Vector3};

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

/// The chord of one motion step of unit arc length: its end relative to the heading at its start.
///
/// A robot that drives one metre while it turns by phi ends at a chord whose components along and
/// across its first heading depend on phi alone. The three integration rules of E2 differ only in
/// these components. As a complex number `along + i across` the chord multiplies the distance
/// driven.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chord {
    /// Along the heading at the start.
    pub along: f64,
    /// Across it, to the left.
    pub across: f64,
}

/// Below this turn \[rad\] the closed forms lose digits to cancellation, so series are used.
const SMALL_TURN: f64 = 1e-2;

impl Chord {
    /// Euler's rule: straight on, as if the heading did not change.
    pub fn euler() -> Self {
        Chord { along: 1.0, across: 0.0 }
    }

    /// The midpoint rule: straight, at the heading of half the turn `phi` \[rad\].
    pub fn midpoint(phi: f64) -> Self {
        let (across, along) = (0.5 * phi).sin_cos();
        Chord { along, across }
    }

    /// The exact arc about the instantaneous centre of rotation:
    /// (sin phi / phi, (1 - cos phi) / phi).
    // ANCHOR: exact-arc
    pub fn exact(phi: f64) -> Self {
        if phi.abs() < SMALL_TURN {
            let p2 = phi * phi;
            let along = 1.0 - p2 / 6.0 * (1.0 - p2 / 20.0 * (1.0 - p2 / 42.0));
            let across = phi / 2.0 * (1.0 - p2 / 12.0 * (1.0 - p2 / 30.0));
            return Chord { along, across };
        }
        let (sin, cos) = phi.sin_cos();
        Chord { along: sin / phi, across: (1.0 - cos) / phi }
    }
    // ANCHOR_END: exact-arc

    /// Derivative of [`midpoint`](Chord::midpoint) over `phi`.
    pub fn midpoint_slope(phi: f64) -> Self {
        let (sin, cos) = (0.5 * phi).sin_cos();
        Chord { along: -0.5 * sin, across: 0.5 * cos }
    }

    /// Derivative of [`exact`](Chord::exact) over `phi`.
    pub fn exact_slope(phi: f64) -> Self {
        if phi.abs() < SMALL_TURN {
            let p2 = phi * phi;
            let along = -phi / 3.0 * (1.0 - p2 / 10.0 * (1.0 - p2 / 28.0));
            let across = 0.5 - p2 / 8.0 * (1.0 - p2 / 18.0);
            return Chord { along, across };
        }
        let (sin, cos) = phi.sin_cos();
        let p2 = phi * phi;
        Chord { along: (phi * cos - sin) / p2, across: (phi * sin + cos - 1.0) / p2 }
    }
}

/// The rule that turns a velocity into the pose one time step later.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Integration {
    /// Straight along the heading at the start of the step.
    Euler,
    /// Straight along the heading at the middle of the step.
    Midpoint,
    /// The exact arc about the instantaneous centre of rotation, stable for `omega -> 0`.
    #[default]
    ExactArc,
}

/// Derivatives of one motion step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepJacobians {
    /// F_x: over the pose (x, y, theta), 3 x 3.
    pub by_pose: Matrix3<f64>,
    /// F_u: over the velocity (vx, vy, omega), 3 x 3. Columns 1 and 3 are the lectures' F_u over
    /// (v, omega).
    pub by_twist: Matrix3<f64>,
}

impl Integration {
    /// All rules, the least accurate first.
    pub const ALL: [Integration; 3] =
        [Integration::Euler, Integration::Midpoint, Integration::ExactArc];

    /// The pose after driving with velocity `twist` for `dt` \[s\].
    pub fn step(self, pose: Pose2, twist: Twist2, dt: f64) -> Pose2 {
        let phi = twist.omega * dt;
        let chord = self.chord(phi);
        let (dx, dy) = rotate(pose.theta, drive(chord, twist, dt));
        Pose2::new(pose.x + dx, pose.y + dy, pose.theta + phi)
    }

    /// The same with its Jacobians over pose and velocity.
    pub fn step_with_jacobians(
        self,
        pose: Pose2,
        twist: Twist2,
        dt: f64,
    ) -> (Pose2, StepJacobians) {
        let phi = twist.omega * dt;
        let chord = self.chord(phi);
        let (dx, dy) = rotate(pose.theta, drive(chord, twist, dt));
        // By vx the step grows along the turned chord, by vy at a right angle to it, and by omega
        // as the chord changes with phi = omega dt.
        let (by_vx, by_vy) = rotate(pose.theta, (chord.along * dt, chord.across * dt));
        let (x_by_omega, y_by_omega) = rotate(pose.theta, drive(self.slope(phi), twist, dt * dt));
        let jacobians = StepJacobians {
            by_pose: Matrix3::new(1.0, 0.0, -dy, 0.0, 1.0, dx, 0.0, 0.0, 1.0),
            by_twist: Matrix3::new(
                by_vx, -by_vy, x_by_omega, //
                by_vy, by_vx, y_by_omega, //
                0.0, 0.0, dt,
            ),
        };
        (Pose2::new(pose.x + dx, pose.y + dy, pose.theta + phi), jacobians)
    }

    fn chord(self, phi: f64) -> Chord {
        match self {
            Integration::Euler => Chord::euler(),
            Integration::Midpoint => Chord::midpoint(phi),
            Integration::ExactArc => Chord::exact(phi),
        }
    }

    fn slope(self, phi: f64) -> Chord {
        match self {
            Integration::Euler => Chord { along: 0.0, across: 0.0 },
            Integration::Midpoint => Chord::midpoint_slope(phi),
            Integration::ExactArc => Chord::exact_slope(phi),
        }
    }
}

/// The displacement in the frame at the start of the step \[m\].
fn drive(chord: Chord, twist: Twist2, dt: f64) -> (f64, f64) {
    (
        (chord.along * twist.vx - chord.across * twist.vy) * dt,
        (chord.across * twist.vx + chord.along * twist.vy) * dt,
    )
}

fn rotate(theta: f64, (x, y): (f64, f64)) -> (f64, f64) {
    let (sin, cos) = theta.sin_cos();
    (cos * x - sin * y, sin * x + cos * y)
}

/// The error model of odometry (E7): variances in proportion to distance driven and angle turned.
///
/// The errors of distance and heading grow like a random walk, so that their variance after a
/// drive does not depend on how finely it is cut into steps.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct VelocityNoise {
    /// Standard deviation of the distance after 1 m \[m\].
    pub distance_sigma: f64,
    /// Standard deviation of the heading after a full turn \[rad\].
    #[cfg_attr(feature = "serde", serde(with = "crate::settings::angle"))]
    pub turn_sigma: f64,
    /// Standard deviation of the heading after 1 m \[rad\].
    #[cfg_attr(feature = "serde", serde(with = "crate::settings::angle"))]
    pub drift_sigma: f64,
}

impl VelocityNoise {
    /// Perfect odometry.
    pub const NONE: VelocityNoise =
        VelocityNoise { distance_sigma: 0.0, turn_sigma: 0.0, drift_sigma: 0.0 };

    /// Variance of the distance, per metre driven \[m^2/m\].
    #[inline]
    pub fn k_d(&self) -> f64 {
        self.distance_sigma * self.distance_sigma
    }

    /// Variance of the heading, per radian turned \[rad^2/rad\].
    #[inline]
    pub fn k_theta(&self) -> f64 {
        self.turn_sigma * self.turn_sigma / std::f64::consts::TAU
    }

    /// Variance of the heading, per metre driven \[rad^2/m\].
    #[inline]
    pub fn k_drift(&self) -> f64 {
        self.drift_sigma * self.drift_sigma
    }

    /// The model from standard deviations, as the lectures give them: `distance` \[m\] after
    /// 1 m, `turn` \[rad\] after a full turn, `drift` \[rad\] after 1 m.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a negative or non-finite value.
    pub fn from_sigmas(distance: f64, turn: f64, drift: f64) -> Result<Self> {
        let noise =
            VelocityNoise { distance_sigma: distance, turn_sigma: turn, drift_sigma: drift };
        noise.check()?;
        Ok(noise)
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for negative values, NaN and infinity.
    pub fn check(&self) -> Result<()> {
        non_negative("distance_sigma of the odometry [m per m]", self.distance_sigma)?;
        non_negative("turn_sigma of the odometry [rad per turn]", self.turn_sigma)?;
        non_negative("drift_sigma of the odometry [rad per m]", self.drift_sigma)?;
        Ok(())
    }

    /// Variances of (vx, vy, omega) over a step of `dt` \[s\]:
    /// `k_d/T |v|` and `k_theta/T |omega| + k_drift/T |v|`.
    ///
    /// A drive that reports no sideways speed has no error of it; one that slides (Mecanum) has
    /// `k_d/T` times the speed in each direction of travel. A step without length has none.
    // ANCHOR: velocity-noise
    pub fn variances(&self, twist: Twist2, dt: f64) -> Vector3<f64> {
        if dt <= 0.0 {
            return Vector3::zeros();
        }
        let per_time = 1.0 / dt;
        Vector3::new(
            self.k_d() * per_time * twist.vx.abs(),
            self.k_d() * per_time * twist.vy.abs(),
            per_time * (self.k_theta() * twist.omega.abs() + self.k_drift() * twist.speed()),
        )
    }
    // ANCHOR_END: velocity-noise

    /// Sigma_u: the diagonal matrix of [`variances`](VelocityNoise::variances).
    pub fn covariance(&self, twist: Twist2, dt: f64) -> Matrix3<f64> {
        Matrix3::from_diagonal(&self.variances(twist, dt))
    }
}

impl Default for VelocityNoise {
    /// 5 cm after 1 m, 5 degrees after a full turn, 2 degrees after 1 m: the lectures' example.
    fn default() -> Self {
        VelocityNoise {
            distance_sigma: 0.05,
            turn_sigma: 5_f64.to_radians(),
            drift_sigma: 2_f64.to_radians(),
        }
    }
}

/// One step of dead reckoning (E6): the mean moves by the integration rule, the covariance follows
/// as `S' = F_x S F_x^T + F_u S_u F_u^T`.
///
/// `belief` is over (x, y, theta) \[m, m, rad\], `dt` in \[s\].
// ANCHOR: dead-reckon
pub fn dead_reckon(
    belief: &Gaussian<3>,
    twist: Twist2,
    dt: f64,
    integration: Integration,
    noise: &VelocityNoise,
) -> Gaussian<3> {
    let pose = Pose2::from_vector(&belief.mean);
    let (moved, jacobians) = integration.step_with_jacobians(pose, twist, dt);
    let (f_x, f_u) = (jacobians.by_pose, jacobians.by_twist);
    let covariance = f_x * belief.covariance * f_x.transpose()
        + f_u * noise.covariance(twist, dt) * f_u.transpose();
    Gaussian { mean: moved.to_vector(), covariance: 0.5 * (covariance + covariance.transpose()) }
}
// ANCHOR_END: dead-reckon
