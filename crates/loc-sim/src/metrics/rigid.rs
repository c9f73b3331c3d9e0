//! What the error figures need of a pose, in the plane and in space alike.

use loc_core::Pose2;
use loc_core::nalgebra::{Isometry3, UnitQuaternion, Vector3};

/// A position with an orientation, in the plane or in space.
///
/// The errors are written once over this trait, so that the figures of planar poses and those of
/// the same poses in space cannot differ.
pub trait RigidPose: Copy {
    /// A pose of the plane z = 0.
    fn from_planar(pose: Pose2) -> Self;

    /// The position \[m\]; z = 0 in the plane.
    fn position(self) -> Vector3<f64>;

    /// The angle of the rotation, in \[0, pi\] \[rad\].
    fn rotation_angle(self) -> f64;

    /// This pose followed by `other`, which is given in this pose's frame.
    #[must_use]
    fn compose(self, other: Self) -> Self;

    /// The pose that undoes this one.
    #[must_use]
    fn inverse(self) -> Self;

    /// `other` as seen from this pose.
    #[must_use]
    fn between(self, other: Self) -> Self;
}

impl RigidPose for Pose2 {
    fn from_planar(pose: Pose2) -> Self {
        pose
    }
    fn position(self) -> Vector3<f64> {
        Vector3::new(self.x, self.y, 0.0)
    }
    fn rotation_angle(self) -> f64 {
        loc_core::angle::wrap(self.theta).abs()
    }
    fn compose(self, other: Self) -> Self {
        Pose2::compose(self, other)
    }
    fn inverse(self) -> Self {
        Pose2::inverse(self)
    }
    fn between(self, other: Self) -> Self {
        Pose2::between(self, other)
    }
}

impl RigidPose for Isometry3<f64> {
    fn from_planar(pose: Pose2) -> Self {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), pose.theta);
        Isometry3::from_parts(Vector3::new(pose.x, pose.y, 0.0).into(), turn)
    }
    fn position(self) -> Vector3<f64> {
        self.translation.vector
    }
    fn rotation_angle(self) -> f64 {
        self.rotation.angle()
    }
    fn compose(self, other: Self) -> Self {
        self * other
    }
    fn inverse(self) -> Self {
        Isometry3::inverse(&self)
    }
    fn between(self, other: Self) -> Self {
        self.inv_mul(&other)
    }
}
