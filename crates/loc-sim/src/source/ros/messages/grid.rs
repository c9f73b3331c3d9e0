//! Maps.

use super::{Header, Message, Pose, Stamp};
use crate::Result;
use crate::source::ros::serialization::{Decoder, Encoder};

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
