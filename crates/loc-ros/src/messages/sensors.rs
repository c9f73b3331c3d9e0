//! Inertial measurements, and positions from satellites.

use super::{Header, Message};
use crate::Result;
use crate::serialization::{Decoder, Encoder};

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

/// `sensor_msgs/msg/NavSatFix`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NavSatFix {
    /// Time, and the frame of the antenna.
    pub header: Header,
    /// -1 no fix, 0 fix, 1 with satellite and 2 with ground augmentation.
    pub status: i8,
    /// Systems used, as bits.
    pub service: u16,
    /// \[deg\].
    pub latitude: f64,
    /// \[deg\].
    pub longitude: f64,
    /// Above the ellipsoid \[m\].
    pub altitude: f64,
    /// East, north, up; by rows \[m^2\].
    pub position_covariance: [f64; 9],
    /// 0 unknown, 1 approximated, 2 its diagonal known, 3 known.
    pub position_covariance_type: u8,
}

impl Message for NavSatFix {
    const NAME: &'static str = "sensor_msgs/msg/NavSatFix";

    fn decode(decoder: &mut Decoder<'_>) -> Result<Self> {
        Ok(NavSatFix {
            header: Header::decode(decoder)?,
            status: decoder.i8("status")?,
            service: decoder.u16("service")?,
            latitude: decoder.f64("latitude")?,
            longitude: decoder.f64("longitude")?,
            altitude: decoder.f64("altitude")?,
            position_covariance: decoder.f64s("position_covariance")?,
            position_covariance_type: decoder.u8("position_covariance_type")?,
        })
    }

    fn encode(&self, encoder: &mut Encoder) {
        self.header.encode(encoder);
        encoder.i8(self.status);
        encoder.u16(self.service);
        encoder.f64s(&[self.latitude, self.longitude, self.altitude]);
        encoder.f64s(&self.position_covariance);
        encoder.u8(self.position_covariance_type);
    }
}
