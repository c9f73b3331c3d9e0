//! How a node is doing.

use super::{Header, Message};
use crate::Result;
use crate::source::ros::serialization::{Decoder, Encoder};

/// `diagnostic_msgs/msg/DiagnosticArray`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DiagnosticArray {
    /// Time.
    pub header: Header,
    /// One entry for each part.
    pub status: Vec<DiagnosticStatus>,
}

/// `diagnostic_msgs/msg/DiagnosticStatus`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DiagnosticStatus {
    /// 0 all well, 1 a warning, 2 an error, 3 stale.
    pub level: u8,
    /// What reports.
    pub name: String,
    /// In words.
    pub message: String,
    /// Which device.
    pub hardware_id: String,
    /// Figures by name.
    pub values: Vec<(String, String)>,
}

impl Message for DiagnosticArray {
    const NAME: &'static str = "diagnostic_msgs/msg/DiagnosticArray";

    fn decode(decoder: &mut Decoder<'_>) -> Result<Self> {
        let header = Header::decode(decoder)?;
        let status = decoder.sequence("status", 17, |decoder| {
            Ok(DiagnosticStatus {
                level: decoder.u8("level")?,
                name: decoder.text("name")?,
                message: decoder.text("message")?,
                hardware_id: decoder.text("hardware_id")?,
                values: decoder.sequence("values", 8, |decoder| {
                    Ok((decoder.text("key")?, decoder.text("value")?))
                })?,
            })
        })?;
        Ok(DiagnosticArray { header, status })
    }

    fn encode(&self, encoder: &mut Encoder) {
        self.header.encode(encoder);
        encoder.sequence(&self.status, |encoder, status| {
            encoder.u8(status.level);
            for text in [&status.name, &status.message, &status.hardware_id] {
                encoder.text(text);
            }
            encoder.sequence(&status.values, |encoder, (key, value)| {
                encoder.text(key);
                encoder.text(value);
            });
        });
    }
}
