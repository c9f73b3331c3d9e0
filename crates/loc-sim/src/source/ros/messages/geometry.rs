//! Poses and velocities in space, with and without covariance.

use crate::Result;
use crate::source::ros::serialization::{Decoder, Encoder};
use loc_core::Pose2;
use loc_core::nalgebra::{Isometry3, Matrix3, Quaternion, Translation3, UnitQuaternion, Vector3};

/// A pose in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// x, y, z \[m\].
    pub position: [f64; 3],
    /// Quaternion x, y, z, w.
    pub orientation: [f64; 4],
}

/// A velocity in space.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Twist {
    /// \[m/s\].
    pub linear: [f64; 3],
    /// \[rad/s\].
    pub angular: [f64; 3],
}

/// Something with its covariance over (x, y, z, rotation about x, y, z), by rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Covariant<T> {
    /// The mean.
    pub pose: T,
    /// 6 x 6, by rows.
    pub covariance: [f64; 36],
}

impl<T: Default> Default for Covariant<T> {
    fn default() -> Self {
        Covariant { pose: T::default(), covariance: [0.0; 36] }
    }
}

impl Default for Pose {
    fn default() -> Self {
        Pose { position: [0.0; 3], orientation: [0.0, 0.0, 0.0, 1.0] }
    }
}

impl From<Pose2> for Pose {
    fn from(pose: Pose2) -> Self {
        let (sin, cos) = (pose.theta / 2.0).sin_cos();
        Pose { position: [pose.x, pose.y, 0.0], orientation: [0.0, 0.0, sin, cos] }
    }
}

impl Pose {
    /// The same as a rigid motion; `None` where a number is not finite or the quaternion is zero.
    pub fn isometry(&self) -> Option<Isometry3<f64>> {
        let [x, y, z, w] = self.orientation;
        let norm = (x * x + y * y + z * z + w * w).sqrt();
        let finite = norm.is_finite() && self.position.iter().all(|p| p.is_finite());
        (finite && norm > 1e-6).then(|| {
            let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
            let [x, y, z] = self.position;
            Isometry3::from_parts(Translation3::new(x, y, z), rotation)
        })
    }

    /// The pose seen from above: x, y and the direction in which the x axis points. `None` as
    /// [`Pose::isometry`].
    pub fn planar(&self) -> Option<Pose2> {
        self.isometry().map(|isometry| planar(&isometry))
    }

    pub(super) fn decode(decoder: &mut Decoder<'_>) -> Result<Self> {
        Ok(Pose { position: decoder.f64s("position")?, orientation: decoder.f64s("orientation")? })
    }

    pub(super) fn encode(&self, encoder: &mut Encoder) {
        encoder.f64s(&self.position);
        encoder.f64s(&self.orientation);
    }
}

/// A rigid motion seen from above.
pub(in crate::source::ros) fn planar(isometry: &Isometry3<f64>) -> Pose2 {
    let ahead = isometry.rotation * Vector3::x();
    Pose2::new(isometry.translation.x, isometry.translation.y, ahead.y.atan2(ahead.x))
}

impl Covariant<Pose> {
    /// A pose in the plane with its covariance over (x, y, theta).
    pub fn planar(pose: Pose2, covariance: Option<Matrix3<f64>>) -> Self {
        let mut full = [0.0; 36];
        for (row, row3) in [0, 1, 5].into_iter().enumerate() {
            for (column, column3) in [0, 1, 5].into_iter().enumerate() {
                full[6 * row3 + column3] = covariance.map_or(0.0, |small| small[(row, column)]);
            }
        }
        Covariant { pose: pose.into(), covariance: full }
    }

    pub(super) fn decode(decoder: &mut Decoder<'_>) -> Result<Self> {
        Ok(Covariant { pose: Pose::decode(decoder)?, covariance: decoder.f64s("covariance")? })
    }

    pub(super) fn encode(&self, encoder: &mut Encoder) {
        self.pose.encode(encoder);
        encoder.f64s(&self.covariance);
    }
}

impl Covariant<Twist> {
    pub(super) fn decode(decoder: &mut Decoder<'_>) -> Result<Self> {
        let pose = Twist { linear: decoder.f64s("linear")?, angular: decoder.f64s("angular")? };
        Ok(Covariant { pose, covariance: decoder.f64s("covariance")? })
    }

    pub(super) fn encode(&self, encoder: &mut Encoder) {
        encoder.f64s(&self.pose.linear);
        encoder.f64s(&self.pose.angular);
        encoder.f64s(&self.covariance);
    }
}
