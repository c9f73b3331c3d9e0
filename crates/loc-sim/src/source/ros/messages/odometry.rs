//! Odometry.

use super::{Covariant, Header, Message, Pose, Twist};
use crate::Result;
use crate::source::ros::serialization::{Decoder, Encoder};

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
