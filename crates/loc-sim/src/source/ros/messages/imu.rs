//! Inertial measurements.

use super::{Header, Message};
use crate::Result;
use crate::source::ros::serialization::{Decoder, Encoder};

/// `sensor_msgs/msg/Imu`. A covariance of zeros is unknown; one that starts with -1 says that the
/// quantity is not measured.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Imu {
    /// Time and frame.
    pub header: Header,
    /// Quaternion x, y, z, w.
    pub orientation: [f64; 4],
    /// 3 x 3, by rows \[rad^2\].
    pub orientation_covariance: [f64; 9],
    /// \[rad/s\].
    pub angular_velocity: [f64; 3],
    /// 3 x 3, by rows.
    pub angular_velocity_covariance: [f64; 9],
    /// \[m/s^2\].
    pub linear_acceleration: [f64; 3],
    /// 3 x 3, by rows.
    pub linear_acceleration_covariance: [f64; 9],
}

impl Message for Imu {
    const NAME: &'static str = "sensor_msgs/msg/Imu";

    fn decode(decoder: &mut Decoder<'_>) -> Result<Self> {
        Ok(Imu {
            header: Header::decode(decoder)?,
            orientation: decoder.f64s("orientation")?,
            orientation_covariance: decoder.f64s("orientation_covariance")?,
            angular_velocity: decoder.f64s("angular_velocity")?,
            angular_velocity_covariance: decoder.f64s("angular_velocity_covariance")?,
            linear_acceleration: decoder.f64s("linear_acceleration")?,
            linear_acceleration_covariance: decoder.f64s("linear_acceleration_covariance")?,
        })
    }

    fn encode(&self, encoder: &mut Encoder) {
        self.header.encode(encoder);
        encoder.f64s(&self.orientation);
        encoder.f64s(&self.orientation_covariance);
        encoder.f64s(&self.angular_velocity);
        encoder.f64s(&self.angular_velocity_covariance);
        encoder.f64s(&self.linear_acceleration);
        encoder.f64s(&self.linear_acceleration_covariance);
    }
}
