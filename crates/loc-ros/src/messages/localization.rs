//! What a localizer gives: poses with a time, paths, particles, the map, how it is doing.

use super::{Covariant, Header, Message, Pose, Stamp};
use crate::Result;
use crate::serialization::{Decoder, Encoder};

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

/// `nav_msgs/msg/OccupancyGrid`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct OccupancyGrid {
    /// Time, and the frame of the map.
    pub header: Header,
    /// When the map was loaded.
    pub map_load_time: Stamp,
    /// Length of a cell's side \[m\].
    pub resolution: f32,
    /// Cells along x.
    pub width: u32,
    /// Cells along y.
    pub height: u32,
    /// Pose of the lower left corner of cell (0, 0).
    pub origin: Pose,
    /// 0 to 100, -1 unknown; by rows from the lower left.
    pub data: Vec<i8>,
}

impl OccupancyGrid {
    /// The message of a map.
    pub fn of(header: Header, map: &loc_maps::OccupancyGrid) -> Self {
        let cells = |count| u32::try_from(count).unwrap_or(u32::MAX);
        OccupancyGrid {
            map_load_time: header.stamp,
            header,
            resolution: map.resolution() as f32,
            width: cells(map.width()),
            height: cells(map.height()),
            origin: map.origin().into(),
            data: map.values().to_vec(),
        }
    }
}

impl Message for OccupancyGrid {
    const NAME: &'static str = "nav_msgs/msg/OccupancyGrid";

    fn decode(decoder: &mut Decoder<'_>) -> Result<Self> {
        Ok(OccupancyGrid {
            header: Header::decode(decoder)?,
            map_load_time: Stamp::decode(decoder)?,
            resolution: decoder.f32("resolution")?,
            width: decoder.u32("width")?,
            height: decoder.u32("height")?,
            origin: Pose::decode(decoder)?,
            data: decoder.bytes("data")?.iter().map(|cell| cell.cast_signed()).collect(),
        })
    }

    fn encode(&self, encoder: &mut Encoder) {
        self.header.encode(encoder);
        self.map_load_time.encode(encoder);
        encoder.f32(self.resolution);
        encoder.u32(self.width);
        encoder.u32(self.height);
        self.origin.encode(encoder);
        let bytes: Vec<u8> = self.data.iter().map(|cell| cell.cast_unsigned()).collect();
        encoder.bytes(&bytes);
    }
}

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
