//! One time step of motion at constant velocity (E2), with its Jacobians (E6).

use super::{Chord, Twist2};
use crate::Pose2;
use nalgebra::Matrix3;

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
    /// All rules, roughest first.
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
