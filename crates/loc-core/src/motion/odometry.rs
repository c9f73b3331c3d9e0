//! The odometry motion model: a step as turn, drive, turn (Probabilistic Robotics, 5.4).

use crate::{Pose2, angle};
use nalgebra::{Matrix3, Vector3};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// A step of the robot, read from two poses of its odometry.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OdometryMotion {
    /// First turn, towards the direction of travel \[rad\]; also known as delta_rot1.
    pub rot1: f64,
    /// Distance driven, negative backwards \[m\]; also known as delta_trans.
    pub trans: f64,
    /// Second turn, to the final heading \[rad\]; also known as delta_rot2.
    pub rot2: f64,
}

/// Noise of the odometry model.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OdometryNoise {
    /// Turn variance per squared turn \[-\].
    pub alpha1: f64,
    /// Turn variance per squared distance \[rad^2/m^2\].
    pub alpha2: f64,
    /// Distance variance per squared distance \[-\].
    pub alpha3: f64,
    /// Distance variance per squared turn \[m^2/rad^2\].
    pub alpha4: f64,
}

impl OdometryMotion {
    /// Below this distance \[m\] the direction of travel is only noise: the whole turn is `rot2`.
    pub const SHORTEST_DRIVE: f64 = 1e-6;

    /// The step that leads from one odometry pose to the next.
    ///
    /// A drive backwards keeps its small turns and gets a negative distance.
    // ANCHOR: odometry-step
    pub fn between(from: Pose2, to: Pose2) -> Self {
        let step = from.between(to);
        let distance = f64::hypot(step.x, step.y);
        if distance < Self::SHORTEST_DRIVE {
            // The part along the heading, with its sign: the jitter of a robot that stands still
            // must not add up to a drive forward.
            return OdometryMotion { rot1: 0.0, trans: step.x, rot2: step.theta };
        }
        let direction = step.y.atan2(step.x);
        let backwards = direction.abs() > std::f64::consts::FRAC_PI_2;
        let (rot1, trans) = if backwards {
            (angle::wrap(direction + std::f64::consts::PI), -distance)
        } else {
            (direction, distance)
        };
        OdometryMotion { rot1, trans, rot2: angle::difference(step.theta, rot1) }
    }
    // ANCHOR_END: odometry-step

    /// The pose after this step from `pose`.
    pub fn apply(self, pose: Pose2) -> Pose2 {
        let direction = pose.theta + self.rot1;
        Pose2::new(
            pose.x + self.trans * direction.cos(),
            pose.y + self.trans * direction.sin(),
            direction + self.rot2,
        )
    }

    /// [`apply`](OdometryMotion::apply) with its derivatives over the pose and over
    /// (rot1, trans, rot2), 3 x 3 each.
    pub fn apply_with_jacobians(self, pose: Pose2) -> (Pose2, Matrix3<f64>, Matrix3<f64>) {
        let (sin, cos) = (pose.theta + self.rot1).sin_cos();
        let (dx, dy) = (self.trans * cos, self.trans * sin);
        let by_pose = Matrix3::new(1.0, 0.0, -dy, 0.0, 1.0, dx, 0.0, 0.0, 1.0);
        let by_step = Matrix3::new(-dy, cos, 0.0, dx, sin, 0.0, 1.0, 0.0, 1.0);
        (self.apply(pose), by_pose, by_step)
    }

    /// Variances of (rot1, trans, rot2) under the given noise.
    // ANCHOR: odometry-noise
    pub fn variances(self, noise: &OdometryNoise) -> Vector3<f64> {
        let [r1, t, r2] = [self.rot1, self.trans, self.rot2].map(|v| v * v);
        Vector3::new(
            noise.alpha1 * r1 + noise.alpha2 * t,
            noise.alpha3 * t + noise.alpha4 * (r1 + r2),
            noise.alpha1 * r2 + noise.alpha2 * t,
        )
    }
    // ANCHOR_END: odometry-noise

    /// A step drawn from the noise around this one.
    pub fn sample<R: Rng + ?Sized>(self, noise: &OdometryNoise, rng: &mut R) -> Self {
        let variances = self.variances(noise);
        let mut draw = |variance: f64| {
            let z: f64 = StandardNormal.sample(rng);
            variance.sqrt() * z
        };
        OdometryMotion {
            rot1: angle::wrap(self.rot1 + draw(variances.x)),
            trans: self.trans + draw(variances.y),
            rot2: angle::wrap(self.rot2 + draw(variances.z)),
        }
    }
}
