//! Poses in the plane: the group SE(2).
//!
//! A pose is where a frame sits in another one: `map_from_base` takes points of the robot's frame
//! to the map's. Poses are chained with `*` (or [`Pose2::compose`]), inverted with
//! [`Pose2::inverse`] and compared with [`Pose2::between`]; each of the three comes with its
//! Jacobians, over the vector (x, y, theta), for propagating covariances.
//!
//! ```
//! use loc_core::Pose2;
//! use std::f64::consts::FRAC_PI_2;
//! let map_from_base = Pose2::new(1.0, 2.0, FRAC_PI_2);
//! let base_from_laser = Pose2::new(0.5, 0.0, 0.0);
//! let map_from_laser = map_from_base * base_from_laser;
//! assert!((map_from_laser.y - 2.5).abs() < 1e-12);
//! ```

use crate::angle;
use crate::motion::Chord;
use nalgebra::{Isometry2, Matrix2, Matrix2x3, Matrix3, Point2, Vector2, Vector3};

/// Position and heading of a frame in the plane.
///
/// Right-handed: x forward, y left, heading counter-clockwise.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Pose2 {
    /// Position along x \[m\].
    pub x: f64,
    /// Position along y \[m\].
    pub y: f64,
    /// Heading \[rad\]; every operation returns it in (-pi, pi].
    pub theta: f64,
}

impl Pose2 {
    /// Checks that all three numbers are finite.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] otherwise.
    pub fn check(&self) -> crate::Result<()> {
        crate::error::finite("x of a pose [m]", self.x)?;
        crate::error::finite("y of a pose [m]", self.y)?;
        crate::error::finite("heading of a pose [rad]", self.theta)?;
        Ok(())
    }

    /// The pose of a frame in itself.
    pub const IDENTITY: Pose2 = Pose2 { x: 0.0, y: 0.0, theta: 0.0 };

    /// A pose from its position \[m\] and its heading \[rad\], which is wrapped.
    pub fn new(x: f64, y: f64, theta: f64) -> Self {
        Pose2 { x, y, theta: angle::wrap(theta) }
    }

    /// A pose from the vector (x, y, theta) \[m, m, rad\].
    pub fn from_vector(v: &Vector3<f64>) -> Self {
        Pose2::new(v.x, v.y, v.z)
    }

    /// The vector (x, y, theta) \[m, m, rad\].
    pub fn to_vector(self) -> Vector3<f64> {
        Vector3::new(self.x, self.y, self.theta)
    }

    /// The position \[m\].
    pub fn position(self) -> Point2<f64> {
        Point2::new(self.x, self.y)
    }

    /// The rotation matrix of the heading.
    pub fn rotation(self) -> Matrix2<f64> {
        let (sin, cos) = self.theta.sin_cos();
        Matrix2::new(cos, -sin, sin, cos)
    }

    /// Whether all three numbers are finite.
    pub fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.theta.is_finite()
    }

    /// This pose followed by `other`, which is given in this pose's frame.
    pub fn compose(self, other: Pose2) -> Pose2 {
        let (sin, cos) = self.theta.sin_cos();
        Pose2::new(
            self.x + cos * other.x - sin * other.y,
            self.y + sin * other.x + cos * other.y,
            self.theta + other.theta,
        )
    }

    /// The pose that undoes this one.
    pub fn inverse(self) -> Pose2 {
        let (sin, cos) = self.theta.sin_cos();
        Pose2::new(-cos * self.x - sin * self.y, sin * self.x - cos * self.y, -self.theta)
    }

    /// `other` as seen from this pose: `self.inverse() * other`.
    pub fn between(self, other: Pose2) -> Pose2 {
        let (sin, cos) = self.theta.sin_cos();
        let (dx, dy) = (other.x - self.x, other.y - self.y);
        Pose2::new(cos * dx + sin * dy, cos * dy - sin * dx, other.theta - self.theta)
    }

    /// A point of this pose's frame, in the frame that the pose is given in \[m\].
    pub fn transform(self, point: &Point2<f64>) -> Point2<f64> {
        Point2::from(self.rotation() * point.coords + Vector2::new(self.x, self.y))
    }

    /// Distance between the positions of two poses \[m\].
    pub fn distance(self, other: Pose2) -> f64 {
        f64::hypot(other.x - self.x, other.y - self.y)
    }

    /// [`compose`](Pose2::compose) with its derivatives over `self` and over `other`, 3 x 3 each
    /// (Smith, Self and Cheeseman 1990, as for the other derivatives here).
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

    /// The exponential map of SE(2): the pose of a frame that moves by (dx, dy, dtheta) with
    /// constant velocity in its own frame for one unit of time.
    ///
    /// Exact arc about the instantaneous centre of rotation, stable as dtheta tends to 0.
    pub fn exp(tangent: &Vector3<f64>) -> Pose2 {
        let chord = Chord::exact(tangent.z);
        let (dx, dy) = (tangent.x, tangent.y);
        Pose2::new(
            chord.along * dx - chord.across * dy,
            chord.across * dx + chord.along * dy,
            tangent.z,
        )
    }

    /// The tangent vector (dx, dy, dtheta) that [`exp`](Pose2::exp) takes to this pose, with
    /// dtheta in (-pi, pi].
    pub fn log(self) -> Vector3<f64> {
        let chord = Chord::exact(self.theta);
        let square = chord.along * chord.along + chord.across * chord.across;
        Vector3::new(
            (chord.along * self.x + chord.across * self.y) / square,
            (chord.along * self.y - chord.across * self.x) / square,
            self.theta,
        )
    }
}

impl std::ops::Mul for Pose2 {
    type Output = Pose2;
    fn mul(self, other: Pose2) -> Pose2 {
        self.compose(other)
    }
}

impl std::fmt::Display for Pose2 {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "({:.3} m, {:.3} m, {:.2} deg)", self.x, self.y, self.theta.to_degrees())
    }
}

impl From<Pose2> for Isometry2<f64> {
    fn from(pose: Pose2) -> Self {
        Isometry2::new(Vector2::new(pose.x, pose.y), pose.theta)
    }
}

impl From<Isometry2<f64>> for Pose2 {
    fn from(isometry: Isometry2<f64>) -> Self {
        let t = isometry.translation;
        Pose2::new(t.x, t.y, isometry.rotation.angle())
    }
}
