//! Derivatives of the pose operations, after Smith, Self and Cheeseman (1990).

use super::Pose2;
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Point2};

impl Pose2 {
    /// [`compose`](Pose2::compose) with its derivatives over `self` and over `other`, 3 x 3 each.
    pub fn compose_jacobians(self, other: Pose2) -> (Pose2, Matrix3<f64>, Matrix3<f64>) {
        let (sin, cos) = self.theta.sin_cos();
        let result = self.compose(other);
        let by_self = Matrix3::new(
            1.0,
            0.0,
            -sin * other.x - cos * other.y, //
            0.0,
            1.0,
            cos * other.x - sin * other.y, //
            0.0,
            0.0,
            1.0,
        );
        let by_other = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        (result, by_self, by_other)
    }

    /// [`inverse`](Pose2::inverse) with its derivative, 3 x 3.
    pub fn inverse_jacobian(self) -> (Pose2, Matrix3<f64>) {
        let (sin, cos) = self.theta.sin_cos();
        let result = self.inverse();
        let by_self = Matrix3::new(-cos, -sin, result.y, sin, -cos, -result.x, 0.0, 0.0, -1.0);
        (result, by_self)
    }

    /// [`between`](Pose2::between) with its derivatives over `self` and over `other`, 3 x 3 each.
    pub fn between_jacobians(self, other: Pose2) -> (Pose2, Matrix3<f64>, Matrix3<f64>) {
        let (sin, cos) = self.theta.sin_cos();
        let result = self.between(other);
        let by_self = Matrix3::new(-cos, -sin, result.y, sin, -cos, -result.x, 0.0, 0.0, -1.0);
        let by_other = Matrix3::new(cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0);
        (result, by_self, by_other)
    }

    /// [`transform`](Pose2::transform) with its derivatives over the pose (2 x 3) and over the
    /// point (2 x 2).
    pub fn transform_jacobians(
        self,
        point: &Point2<f64>,
    ) -> (Point2<f64>, Matrix2x3<f64>, Matrix2<f64>) {
        let result = self.transform(point);
        let (dx, dy) = (result.x - self.x, result.y - self.y);
        let by_pose = Matrix2x3::new(1.0, 0.0, -dy, 0.0, 1.0, dx);
        (result, by_pose, self.rotation())
    }
}
