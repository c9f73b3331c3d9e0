//! Scans of lasers, and clouds of points.

use super::{Header, Message};
use crate::serialization::{Decoder, Encoder};
use crate::{Error, Result};
use loc_sensors::laser;
use std::f32::consts::PI;

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
    /// The message of a scan.
    pub fn of(header: Header, scan: &laser::LaserScan) -> Self {
        let numbers = |values: &[f64]| values.iter().map(|value| *value as f32).collect();
        LaserScan {
            header,
            angle_min: scan.angle_min as f32,
            angle_max: scan.angle_max as f32,
            angle_increment: scan.angle_increment as f32,
            time_increment: scan.time_increment as f32,
            scan_time: scan.scan_time as f32,
            range_min: scan.range_min as f32,
            range_max: scan.range_max as f32,
            ranges: numbers(&scan.ranges),
            intensities: numbers(&scan.intensities),
        }
    }

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

/// `sensor_msgs/msg/PointCloud2`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PointCloud2 {
    /// Time and frame.
    pub header: Header,
    /// Rows; 1 for points without order.
    pub height: u32,
    /// Points in a row.
    pub width: u32,
    /// What a point holds.
    pub fields: Vec<PointField>,
    /// Whether the numbers in `data` are big-endian.
    pub is_bigendian: bool,
    /// Bytes of a point.
    pub point_step: u32,
    /// Bytes of a row.
    pub row_step: u32,
    /// The points.
    pub data: Vec<u8>,
    /// Whether every point is valid.
    pub is_dense: bool,
}

/// `sensor_msgs/msg/PointField`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PointField {
    /// Its name, such as `x`.
    pub name: String,
    /// Its first byte in a point.
    pub offset: u32,
    /// 7 for floats of 32 bits, 8 for those of 64.
    pub datatype: u8,
    /// How many numbers it is.
    pub count: u32,
}

const FLOAT32: u8 = 7;
const FLOAT64: u8 = 8;

/// What a scan is cut out of a cloud by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slice {
    /// Heights in the cloud's frame that count \[m\].
    pub heights: [f32; 2],
    /// Beams of the scan, over a full turn.
    pub beams: usize,
    /// Ranges that count \[m\].
    pub ranges: [f32; 2],
}

impl Default for Slice {
    /// 10 cm above and below the sensor, half a degree, 0.1 to 100 m.
    fn default() -> Self {
        Slice { heights: [-0.1, 0.1], beams: 720, ranges: [0.1, 100.0] }
    }
}

impl PointCloud2 {
    /// A cloud of points that are floats x, y, z.
    pub fn of(header: Header, points: &[[f32; 3]]) -> Self {
        let field = |(index, name): (u32, &str)| PointField {
            name: name.into(),
            offset: 4 * index,
            datatype: FLOAT32,
            count: 1,
        };
        let width = u32::try_from(points.len()).unwrap_or(u32::MAX);
        PointCloud2 {
            header,
            height: 1,
            width,
            fields: (0..).zip(["x", "y", "z"]).map(field).collect(),
            is_bigendian: false,
            point_step: 12,
            row_step: width.saturating_mul(12),
            data: points.iter().flatten().flat_map(|number| number.to_le_bytes()).collect(),
            is_dense: true,
        }
    }

    /// The points as x, y, z.
    ///
    /// # Errors
    /// [`Error::Malformed`] for a cloud without these as floats, or with fewer bytes than its
    /// points need.
    pub fn points(&self) -> Result<Vec<[f32; 3]>> {
        let axes = ["x", "y", "z"].map(|name| self.float(name));
        let [x, y, z] = axes;
        let (x, y, z) = (x?, y?, z?);
        let (step, row) = (self.point_step as usize, self.row_step as usize);
        let (width, height) = (self.width as usize, self.height as usize);
        if width == 0 || height == 0 {
            return Ok(Vec::new());
        }
        let of_a_row = width.checked_mul(step);
        let needed = of_a_row.and_then(|last| row.checked_mul(height - 1)?.checked_add(last));
        // Rows that lie on one another would make millions of points of a few bytes.
        let overlap = height > 1 && of_a_row.is_none_or(|bytes| bytes > row);
        if step == 0 || overlap || needed.is_none_or(|needed| needed > self.data.len()) {
            let expected = format!("{height} rows of {width} points of {step} bytes");
            let found = format!("{} bytes, rows of {row}", self.data.len());
            return Err(Error::Malformed { what: "data of the cloud".into(), expected, found });
        }
        let point = |start: usize| -> Option<[f32; 3]> {
            let point = self.data.get(start..start + step)?;
            Some([self.number(point, x)?, self.number(point, y)?, self.number(point, z)?])
        };
        let starts = (0..height).flat_map(|r| (0..width).map(move |p| r * row + p * step));
        Ok(starts.filter_map(point).collect())
    }

    /// The field of a name, which must be a float.
    fn float(&self, name: &str) -> Result<&PointField> {
        let found = self.fields.iter().find(|field| field.name == name);
        let fits = |field: &&PointField| {
            let size = if field.datatype == FLOAT32 { 4 } else { 8 };
            matches!(field.datatype, FLOAT32 | FLOAT64)
                && field.offset.checked_add(size).is_some_and(|end| end <= self.point_step)
        };
        found.filter(fits).ok_or_else(|| Error::Malformed {
            what: format!("field {name} of the cloud"),
            expected: "a float within the point".into(),
            found: found.map_or("none".into(), |field| format!("{field:?}")),
        })
    }

    fn number(&self, point: &[u8], field: &PointField) -> Option<f32> {
        let bytes = point.get(field.offset as usize..)?;
        Some(match (field.datatype, self.is_bigendian) {
            (FLOAT32, false) => f32::from_le_bytes(*bytes.first_chunk()?),
            (FLOAT32, true) => f32::from_be_bytes(*bytes.first_chunk()?),
            (_, false) => f64::from_le_bytes(*bytes.first_chunk()?) as f32,
            (_, true) => f64::from_be_bytes(*bytes.first_chunk()?) as f32,
        })
    }

    /// The nearest point in each direction of those between two heights, as a scan of a full turn
    /// from -pi; +inf where there is none.
    ///
    /// # Errors
    /// As [`PointCloud2::points`].
    pub fn slice(&self, slice: &Slice) -> Result<LaserScan> {
        let mut ranges = vec![f32::INFINITY; slice.beams.max(1)];
        let increment = 2.0 * PI / ranges.len() as f32;
        for [x, y, z] in self.points()? {
            let range = x.hypot(y);
            let counts = (slice.heights[0]..=slice.heights[1]).contains(&z)
                && (slice.ranges[0]..=slice.ranges[1]).contains(&range);
            if counts {
                // The middle of a beam is its direction.
                let beam = ((y.atan2(x) + PI) / increment).round() as usize % ranges.len();
                ranges[beam] = ranges[beam].min(range);
            }
        }
        Ok(LaserScan {
            header: self.header.clone(),
            angle_min: -PI,
            angle_max: -PI + increment * (ranges.len() - 1) as f32,
            angle_increment: increment,
            time_increment: 0.0,
            scan_time: 0.0,
            range_min: slice.ranges[0],
            range_max: slice.ranges[1],
            ranges,
            intensities: Vec::new(),
        })
    }
}

impl Message for PointCloud2 {
    const NAME: &'static str = "sensor_msgs/msg/PointCloud2";

    fn decode(decoder: &mut Decoder<'_>) -> Result<Self> {
        Ok(PointCloud2 {
            header: Header::decode(decoder)?,
            height: decoder.u32("height")?,
            width: decoder.u32("width")?,
            fields: decoder.sequence("fields", 13, |decoder| {
                Ok(PointField {
                    name: decoder.text("name")?,
                    offset: decoder.u32("offset")?,
                    datatype: decoder.u8("datatype")?,
                    count: decoder.u32("count")?,
                })
            })?,
            is_bigendian: decoder.u8("is_bigendian")? != 0,
            point_step: decoder.u32("point_step")?,
            row_step: decoder.u32("row_step")?,
            data: decoder.bytes("data")?.to_vec(),
            is_dense: decoder.u8("is_dense")? != 0,
        })
    }

    fn encode(&self, encoder: &mut Encoder) {
        self.header.encode(encoder);
        encoder.u32(self.height);
        encoder.u32(self.width);
        encoder.sequence(&self.fields, |encoder, field| {
            encoder.text(&field.name);
            encoder.u32(field.offset);
            encoder.u8(field.datatype);
            encoder.u32(field.count);
        });
        encoder.u8(self.is_bigendian.into());
        encoder.u32(self.point_step);
        encoder.u32(self.row_step);
        encoder.bytes(&self.data);
        encoder.u8(self.is_dense.into());
    }
}
