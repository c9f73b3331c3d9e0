//! The types of messages that a localizer reads and writes, with the fields that ROS gives them.
//!
//! A [`Message`] is decoded from the bytes of a bag, and encoded again, in the serialisation of
//! ROS 1 or ROS 2. Numbers stay as they are, infinity and NaN included; what they mean, and whether
//! they make sense, is for those to say who use them.
//!
//! ```
//! use loc_ros::messages::{Message, Odometry};
//! use loc_ros::{Dialect, Encoding};
//! let mut odometry = Odometry { child_frame_id: "base_link".into(), ..Odometry::default() };
//! odometry.pose.pose.position = [1.0, 2.0, f64::NAN];
//! let bytes = odometry.to_bytes(Dialect::Cdr);
//! let again = Odometry::from_bytes(&bytes, &Encoding::Cdr)?;
//! assert_eq!(again.pose.pose.position[..2], [1.0, 2.0]);
//! assert!(again.pose.pose.position[2].is_nan());
//! # Ok::<(), loc_ros::Error>(())
//! ```

mod definitions;
mod geometry;
mod laser;
mod localization;
mod sensors;

pub use definitions::definition;
pub(crate) use geometry::planar;
pub use geometry::{Covariant, Odometry, Pose, TfMessage, TransformStamped, Twist};
pub use laser::{LaserScan, MultiEchoLaserScan, PointCloud2, PointField, Slice};
pub use localization::{
    DiagnosticArray, DiagnosticStatus, OccupancyGrid, ParticleCloud, Path, PoseArray, PoseStamped,
    PoseWithCovarianceStamped,
};
pub use sensors::{Imu, NavSatFix};

use crate::Result;
use crate::bag::Encoding;
use crate::serialization::{Decoder, Dialect, Encoder};

/// A type of messages.
pub trait Message: Sized {
    /// Its name in ROS 2, such as `sensor_msgs/msg/LaserScan`.
    const NAME: &'static str;

    /// Takes the fields off the front of the bytes.
    ///
    /// # Errors
    /// [`crate::Error::Malformed`] with the field for which the bytes do not suffice.
    fn decode(decoder: &mut Decoder<'_>) -> Result<Self>;

    /// Puts the fields at the end of the bytes.
    fn encode(&self, encoder: &mut Encoder);

    /// The message that these bytes are.
    ///
    /// # Errors
    /// As [`Message::decode`]; for an encoding that is not read, too.
    fn from_bytes(bytes: &[u8], encoding: &Encoding) -> Result<Self> {
        Self::decode(&mut Decoder::new(bytes, encoding)?)
    }

    /// Its bytes.
    fn to_bytes(&self, dialect: Dialect) -> Vec<u8> {
        let mut encoder = Encoder::new(dialect);
        self.encode(&mut encoder);
        encoder.finish()
    }
}

/// Nanoseconds in a second.
const SECOND: i64 = 1_000_000_000;

/// A time of a message, in nanoseconds since 1970 or since the start of a simulated clock.
///
/// Nanoseconds since 1970 do not fit into an `f64`, so that differences are taken before seconds
/// are made of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Hash)]
pub struct Stamp(pub i64);

impl Stamp {
    /// The nearest stamp to a time \[s\]; 0 for one that is not finite.
    pub fn from_seconds(seconds: f64) -> Self {
        let whole = seconds.floor();
        // A cast saturates, and makes 0 of NaN.
        let nanoseconds = ((seconds - whole) * SECOND as f64).round() as i64;
        Stamp((whole as i64).saturating_mul(SECOND).saturating_add(nanoseconds))
    }

    /// The time \[s\], to some hundred nanoseconds for one of our days.
    pub fn seconds(self) -> f64 {
        self.0.div_euclid(SECOND) as f64 + self.0.rem_euclid(SECOND) as f64 / SECOND as f64
    }

    /// How much later this is than another \[s\]. Times that lie farther apart than 292 years are
    /// taken to be that far.
    pub fn seconds_since(self, earlier: Stamp) -> f64 {
        self.0.saturating_sub(earlier.0) as f64 * 1e-9
    }

    pub(super) fn decode(decoder: &mut Decoder<'_>) -> Result<Self> {
        let seconds = match decoder.dialect() {
            Dialect::Ros1 => i64::from(decoder.u32("seconds of the stamp")?),
            _ => i64::from(decoder.i32("seconds of the stamp")?),
        };
        let nanoseconds = decoder.u32("nanoseconds of the stamp")?;
        Ok(Stamp(seconds * SECOND + i64::from(nanoseconds)))
    }

    pub(super) fn encode(self, encoder: &mut Encoder) {
        let seconds = self.0.div_euclid(SECOND);
        match encoder.dialect() {
            Dialect::Ros1 => encoder.u32(u32::try_from(seconds.max(0)).unwrap_or(u32::MAX)),
            _ => encoder.i32(seconds.clamp(i32::MIN.into(), i32::MAX.into()) as i32),
        }
        encoder.u32(self.0.rem_euclid(SECOND) as u32);
    }
}

/// When a message was measured, and in which frame.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Header {
    /// The time.
    pub stamp: Stamp,
    /// The frame.
    pub frame_id: String,
}

impl Header {
    /// A header.
    pub fn new(stamp: Stamp, frame_id: &str) -> Self {
        Header { stamp, frame_id: frame_id.into() }
    }

    pub(super) fn decode(decoder: &mut Decoder<'_>) -> Result<Self> {
        if decoder.dialect() == Dialect::Ros1 {
            decoder.u32("number of the message")?;
        }
        Ok(Header { stamp: Stamp::decode(decoder)?, frame_id: decoder.text("frame_id")? })
    }

    pub(super) fn encode(&self, encoder: &mut Encoder) {
        if encoder.dialect() == Dialect::Ros1 {
            encoder.u32(0);
        }
        self.stamp.encode(encoder);
        encoder.text(&self.frame_id);
    }
}
