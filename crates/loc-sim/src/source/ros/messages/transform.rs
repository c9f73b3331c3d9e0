//! Transforms between frames.

use super::{Header, Message, Pose};
use crate::Result;
use crate::source::ros::serialization::{Decoder, Encoder};

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
