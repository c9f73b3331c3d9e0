//! Scans of lasers.

use super::{Header, Message};
use crate::Result;
use crate::source::ros::serialization::{Decoder, Encoder};

/// `sensor_msgs/msg/LaserScan`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LaserScan {
    /// Time of the first ray, and the laser's frame.
    pub header: Header,
    /// \[rad\].
    pub angle_min: f32,
    /// \[rad\].
    pub angle_max: f32,
    /// \[rad\].
    pub angle_increment: f32,
    /// \[s\].
    pub time_increment: f32,
    /// \[s\].
    pub scan_time: f32,
    /// \[m\].
    pub range_min: f32,
    /// \[m\].
    pub range_max: f32,
    /// \[m\].
    pub ranges: Vec<f32>,
    /// In the device's own unit; may be empty.
    pub intensities: Vec<f32>,
}

/// `sensor_msgs/msg/MultiEchoLaserScan`: several ranges in each direction.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MultiEchoLaserScan {
    /// The numbers that it shares with a scan of one echo; its ranges and intensities are empty.
    pub scan: LaserScan,
    /// Ranges of each beam \[m\].
    pub ranges: Vec<Vec<f32>>,
    /// Intensities of each beam; may be empty.
    pub intensities: Vec<Vec<f32>>,
}

impl LaserScan {
    /// The fields before the ranges.
    fn decode_head(decoder: &mut Decoder<'_>) -> Result<Self> {
        Ok(LaserScan {
            header: Header::decode(decoder)?,
            angle_min: decoder.f32("angle_min")?,
            angle_max: decoder.f32("angle_max")?,
            angle_increment: decoder.f32("angle_increment")?,
            time_increment: decoder.f32("time_increment")?,
            scan_time: decoder.f32("scan_time")?,
            range_min: decoder.f32("range_min")?,
            range_max: decoder.f32("range_max")?,
            ranges: Vec::new(),
            intensities: Vec::new(),
        })
    }

    fn encode_head(&self, encoder: &mut Encoder) {
        self.header.encode(encoder);
        for number in [
            self.angle_min,
            self.angle_max,
            self.angle_increment,
            self.time_increment,
            self.scan_time,
            self.range_min,
            self.range_max,
        ] {
            encoder.f32(number);
        }
    }
}

impl Message for LaserScan {
    const NAME: &'static str = "sensor_msgs/msg/LaserScan";

    fn decode(decoder: &mut Decoder<'_>) -> Result<Self> {
        let head = LaserScan::decode_head(decoder)?;
        let ranges = decoder.f32s("ranges")?;
        Ok(LaserScan { ranges, intensities: decoder.f32s("intensities")?, ..head })
    }

    fn encode(&self, encoder: &mut Encoder) {
        self.encode_head(encoder);
        encoder.f32s(&self.ranges);
        encoder.f32s(&self.intensities);
    }
}

impl MultiEchoLaserScan {
    /// The scan of the first echo of each beam, the nearest thing that it met; a beam without any
    /// has +inf.
    pub fn first_echo(self) -> LaserScan {
        let first = |echoes: &Vec<f32>, none| echoes.first().copied().unwrap_or(none);
        LaserScan {
            ranges: self.ranges.iter().map(|echoes| first(echoes, f32::INFINITY)).collect(),
            intensities: self.intensities.iter().map(|echoes| first(echoes, 0.0)).collect(),
            ..self.scan
        }
    }
}

impl Message for MultiEchoLaserScan {
    const NAME: &'static str = "sensor_msgs/msg/MultiEchoLaserScan";

    fn decode(decoder: &mut Decoder<'_>) -> Result<Self> {
        let scan = LaserScan::decode_head(decoder)?;
        let mut echoes = |what| decoder.sequence(what, 4, |decoder| decoder.f32s(what));
        Ok(MultiEchoLaserScan {
            scan,
            ranges: echoes("ranges")?,
            intensities: echoes("intensities")?,
        })
    }

    fn encode(&self, encoder: &mut Encoder) {
        self.scan.encode_head(encoder);
        for echoes in [&self.ranges, &self.intensities] {
            encoder.sequence(echoes, |encoder, echoes| encoder.f32s(echoes));
        }
    }
}
