//! Poses and velocities in space, with and without covariance; odometry and transforms.

use super::{Header, Message};
use crate::Result;
use crate::serialization::{Decoder, Encoder};
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
pub(crate) fn planar(isometry: &Isometry3<f64>) -> Pose2 {
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

/// `nav_msgs/msg/Odometry`: the pose of `child_frame_id` in the header's frame, and its velocity
/// in `child_frame_id`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Odometry {
    /// Time, and the frame of the odometry.
    pub header: Header,
    /// The frame of the robot.
    pub child_frame_id: String,
    /// The pose.
    pub pose: Covariant<Pose>,
    /// The velocity.
    pub twist: Covariant<Twist>,
}

impl Message for Odometry {
    const NAME: &'static str = "nav_msgs/msg/Odometry";

    fn decode(decoder: &mut Decoder<'_>) -> Result<Self> {
        Ok(Odometry {
            header: Header::decode(decoder)?,
            child_frame_id: decoder.text("child_frame_id")?,
            pose: Covariant::<Pose>::decode(decoder)?,
            twist: Covariant::<Twist>::decode(decoder)?,
        })
    }

    fn encode(&self, encoder: &mut Encoder) {
        self.header.encode(encoder);
        encoder.text(&self.child_frame_id);
        self.pose.encode(encoder);
        self.twist.encode(encoder);
    }
}

/// `geometry_msgs/msg/TransformStamped`: the pose of `child_frame_id` in the header's frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TransformStamped {
    /// Time, and the parent frame.
    pub header: Header,
    /// The child frame.
    pub child_frame_id: String,
    /// `parent_from_child`.
    pub transform: Pose,
}

/// `tf2_msgs/msg/TFMessage`, in old bags `tf/tfMessage`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TfMessage {
    /// The transforms.
    pub transforms: Vec<TransformStamped>,
}

impl Message for TfMessage {
    const NAME: &'static str = "tf2_msgs/msg/TFMessage";

    fn decode(decoder: &mut Decoder<'_>) -> Result<Self> {
        let transforms = decoder.sequence("transforms", 72, |decoder| {
            Ok(TransformStamped {
                header: Header::decode(decoder)?,
                child_frame_id: decoder.text("child_frame_id")?,
                transform: Pose::decode(decoder)?,
            })
        })?;
        Ok(TfMessage { transforms })
    }

    fn encode(&self, encoder: &mut Encoder) {
        encoder.sequence(&self.transforms, |encoder, transform| {
            transform.header.encode(encoder);
            encoder.text(&transform.child_frame_id);
            transform.transform.encode(encoder);
        });
    }
}
