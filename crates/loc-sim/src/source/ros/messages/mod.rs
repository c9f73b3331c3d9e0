//! The types of messages that a localizer reads and writes, with the fields that ROS gives them.
//!
//! A [`Message`] is decoded from the bytes of a bag, and encoded again, in the serialisation of
//! ROS 1 or ROS 2. Numbers stay as they are, infinity and NaN included; what they mean, and whether
//! they make sense, is for those to say who use them.
//!
//! ```
//! use loc_sim::source::ros::messages::{Message, Odometry};
//! use loc_sim::source::ros::{Dialect, Encoding};
//! let mut odometry = Odometry { child_frame_id: "base_link".into(), ..Odometry::default() };
//! odometry.pose.pose.position = [1.0, 2.0, f64::NAN];
//! let bytes = odometry.to_bytes(Dialect::Cdr);
//! let again = Odometry::from_bytes(&bytes, &Encoding::Cdr)?;
//! assert_eq!(again.pose.pose.position[..2], [1.0, 2.0]);
//! assert!(again.pose.pose.position[2].is_nan());
//! # Ok::<(), loc_sim::Error>(())
//! ```

mod definitions;
mod diagnostics;
mod geometry;
mod grid;
mod imu;
mod laser;
mod odometry;
mod particles;
mod point_cloud;
mod poses;
mod satellite;
mod stamp;
mod transform;

pub use definitions::definition;
pub use diagnostics::{DiagnosticArray, DiagnosticStatus};
pub(in crate::source::ros) use geometry::planar;
pub use geometry::{Covariant, Pose, Twist};
pub use grid::OccupancyGrid;
pub use imu::Imu;
pub use laser::{LaserScan, MultiEchoLaserScan};
pub use odometry::Odometry;
pub use particles::ParticleCloud;
pub use point_cloud::{PointCloud2, PointField, Slice};
pub use poses::{Path, PoseArray, PoseStamped, PoseWithCovarianceStamped};
pub use satellite::NavSatFix;
pub use stamp::{Header, Stamp};
pub use transform::{TfMessage, TransformStamped};

use super::bag::Encoding;
use super::serialization::{Decoder, Dialect, Encoder};
use crate::Result;

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
