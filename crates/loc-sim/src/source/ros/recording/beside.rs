//! Inertial units and satellite receivers, beside the laser.
//!
//! A sample of an inertial unit is turned into the robot's axes by the transforms of the bag, and
//! freed of the centripetal acceleration that its place off the middle brings (B3). A position
//! becomes east and north of the first one with a fix, which is the origin of the map: x east, y
//! north, on the plane that touches the ellipsoid there (WGS84). The antenna is taken for the
//! middle of the robot.

use crate::Result;
use crate::source::ros::messages::{Imu, NavSatFix};
use loc_core::Gaussian;
use loc_core::nalgebra::{Isometry3, Matrix2, Matrix3, Vector2, Vector3};
use loc_sensors::gnss::{Geodetic, GnssFix, GnssNoise, LocalFrame};
use loc_sensors::imu::ImuReading;

/// What marks a quantity that a unit does not measure, at the front of its covariance.
const NOT_MEASURED: f64 = -1.0;

/// The largest standard deviation of a position that still tells something \[m\].
const LARGEST_SIGMA: f64 = 1e4;

/// A sample in the unit's own axes; `None` where the unit measures only half of it.
pub(super) fn sample(imu: &Imu) -> Result<Option<ImuReading>> {
    let covariances = [imu.angular_velocity_covariance, imu.linear_acceleration_covariance];
    if covariances.iter().any(|covariance| covariance[0].total_cmp(&NOT_MEASURED).is_eq()) {
        return Ok(None);
    }
    let reading = ImuReading {
        acceleration: Vector3::from(imu.linear_acceleration),
        angular_velocity: Vector3::from(imu.angular_velocity),
    };
    reading.check()?;
    Ok(Some(reading))
}

/// The same in the robot's axes, in its middle; `place` is `base_from_unit`.
pub(super) fn in_the_middle(reading: &ImuReading, place: &Isometry3<f64>) -> ImuReading {
    let turn = place.rotation * reading.angular_velocity;
    let centripetal = turn.cross(&turn.cross(&place.translation.vector));
    let acceleration = place.rotation * reading.acceleration - centripetal;
    ImuReading { acceleration, angular_velocity: turn }
}

/// Makes positions of fixes.
#[derive(Debug, Default)]
pub(super) struct Satellites {
    /// About the first fix.
    frame: Option<LocalFrame>,
}

impl Satellites {
    /// East and north of the first fix; `None` where the receiver had none.
    ///
    /// A covariance that is unknown, or none, is that of a usual receiver ([`GnssNoise::neo_m8`]).
    pub(super) fn position(&mut self, fix: &NavSatFix) -> Result<Option<Gaussian<2>>> {
        if fix.status < 0 {
            return Ok(None);
        }
        let position = Geodetic::from_degrees(fix.latitude, fix.longitude, fix.altitude)?;
        position.check()?;
        let frame = match self.frame {
            Some(frame) => frame,
            None => *self.frame.insert(LocalFrame::new(position)?),
        };
        let covariance = Matrix3::from_row_slice(&fix.position_covariance);
        let claimed = GnssFix { position, covariance }.in_plane(&frame);
        let is_known = fix.position_covariance_type != 0 && is_usable(&claimed.covariance);
        let usual = Matrix2::from_diagonal(&Vector2::repeat(GnssNoise::neo_m8().sigma().powi(2)));
        let covariance = if is_known { claimed.covariance } else { usual };
        Ok(Some(Gaussian { covariance, ..claimed }))
    }

    /// Where the map's origin is, as a line for the user.
    pub(super) fn note(&self) -> Option<String> {
        let origin = self.frame?.origin();
        let (latitude, longitude) = (origin.latitude.to_degrees(), origin.longitude.to_degrees());
        Some(format!(
            "positions of satellites are east and north of the first, {latitude:.7}, {longitude:.7}"
        ))
    }
}

/// Whether it is the covariance of something.
fn is_usable(covariance: &Matrix2<f64>) -> bool {
    let most = LARGEST_SIGMA * LARGEST_SIGMA;
    let symmetric = (covariance.m12 - covariance.m21).abs() <= 1e-6 * covariance.trace().abs();
    let within = |value: f64| value > 0.0 && value <= most;
    symmetric && within(covariance.m11) && within(covariance.m22) && covariance.determinant() > 0.0
}
