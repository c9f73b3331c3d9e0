//! Poses with a time: one, one with covariance, many, and a path.

use super::{Covariant, Header, Message, Pose};
use crate::Result;
use crate::source::ros::serialization::{Decoder, Encoder};

/// `geometry_msgs/msg/PoseStamped`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PoseStamped {
    /// Time and frame.
    pub header: Header,
    /// The pose.
    pub pose: Pose,
}

/// `geometry_msgs/msg/PoseWithCovarianceStamped`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PoseWithCovarianceStamped {
    /// Time and frame.
    pub header: Header,
    /// The pose with its covariance.
    pub pose: Covariant<Pose>,
}

/// `geometry_msgs/msg/PoseArray`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PoseArray {
    /// Time and frame.
    pub header: Header,
    /// The poses.
    pub poses: Vec<Pose>,
}

/// `nav_msgs/msg/Path`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Path {
    /// Time and frame.
    pub header: Header,
    /// The poses.
    pub poses: Vec<PoseStamped>,
}

impl Message for PoseStamped {
    const NAME: &'static str = "geometry_msgs/msg/PoseStamped";

    fn decode(decoder: &mut Decoder<'_>) -> Result<Self> {
        Ok(PoseStamped { header: Header::decode(decoder)?, pose: Pose::decode(decoder)? })
    }

    fn encode(&self, encoder: &mut Encoder) {
        self.header.encode(encoder);
        self.pose.encode(encoder);
    }
}

impl Message for PoseWithCovarianceStamped {
    const NAME: &'static str = "geometry_msgs/msg/PoseWithCovarianceStamped";

    fn decode(decoder: &mut Decoder<'_>) -> Result<Self> {
        let header = Header::decode(decoder)?;
        Ok(PoseWithCovarianceStamped { header, pose: Covariant::<Pose>::decode(decoder)? })
    }

    fn encode(&self, encoder: &mut Encoder) {
        self.header.encode(encoder);
        self.pose.encode(encoder);
    }
}

impl Message for PoseArray {
    const NAME: &'static str = "geometry_msgs/msg/PoseArray";

    fn decode(decoder: &mut Decoder<'_>) -> Result<Self> {
        let header = Header::decode(decoder)?;
        Ok(PoseArray { header, poses: decoder.sequence("poses", 56, Pose::decode)? })
    }

    fn encode(&self, encoder: &mut Encoder) {
        self.header.encode(encoder);
        encoder.sequence(&self.poses, |encoder, pose| pose.encode(encoder));
    }
}

impl Message for Path {
    const NAME: &'static str = "nav_msgs/msg/Path";

    fn decode(decoder: &mut Decoder<'_>) -> Result<Self> {
        let header = Header::decode(decoder)?;
        Ok(Path { header, poses: decoder.sequence("poses", 68, PoseStamped::decode)? })
    }

    fn encode(&self, encoder: &mut Encoder) {
        self.header.encode(encoder);
        encoder.sequence(&self.poses, |encoder, pose| pose.encode(encoder));
    }
}
