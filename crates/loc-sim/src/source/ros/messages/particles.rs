//! Particles.

use super::{Header, Message, Pose};
use crate::Result;
use crate::source::ros::serialization::{Decoder, Encoder};

/// `nav2_msgs/msg/ParticleCloud`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ParticleCloud {
    /// Time and frame.
    pub header: Header,
    /// Poses with their weights.
    pub particles: Vec<(Pose, f64)>,
}

impl Message for ParticleCloud {
    const NAME: &'static str = "nav2_msgs/msg/ParticleCloud";

    fn decode(decoder: &mut Decoder<'_>) -> Result<Self> {
        let header = Header::decode(decoder)?;
        let particles = decoder.sequence("particles", 64, |decoder| {
            Ok((Pose::decode(decoder)?, decoder.f64("weight")?))
        })?;
        Ok(ParticleCloud { header, particles })
    }

    fn encode(&self, encoder: &mut Encoder) {
        self.header.encode(encoder);
        encoder.sequence(&self.particles, |encoder, (pose, weight)| {
            pose.encode(encoder);
            encoder.f64(*weight);
        });
    }
}
