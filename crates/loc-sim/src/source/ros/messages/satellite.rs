//! Positions from satellites.

use super::{Header, Message};
use crate::Result;
use crate::source::ros::serialization::{Decoder, Encoder};

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
