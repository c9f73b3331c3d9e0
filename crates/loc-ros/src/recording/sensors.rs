//! From messages to measurements: scans, inertial samples, satellite fixes, odometry with noise.
//!
//! A scan gets the pose of its laser seen from above. A sample of an inertial unit is turned into
//! the robot's axes by the transforms of the bag, and freed of the centripetal acceleration that
//! its offset from the middle brings (B3). A satellite fix becomes east and north of the first one
//! with a fix, which is the origin of the map: x east, y north, on the plane that touches the
//! ellipsoid there (WGS84). The antenna is taken for the middle of the robot.

use crate::messages::{self, Imu, NavSatFix};
use crate::{Error, Result};
use loc_core::motion::VelocityNoise;
use loc_core::nalgebra::{Isometry3, Matrix2, Matrix3, Vector2, Vector3};
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Gaussian, Pose2, angle};
use loc_sensors::gnss::{Geodetic, GnssFix, GnssNoise, LocalFrame};
use loc_sensors::imu::ImuReading;
use loc_sensors::laser::LaserScan;
use rand_distr::{Distribution, StandardNormal};

/// How far a laser may be tilted and still count as level: cos 10 degrees.
const LEVEL: f64 = 0.985;

/// What marks a quantity that a unit does not measure, at the front of its covariance.
const NOT_MEASURED: f64 = -1.0;

/// A position with a larger standard deviation carries no information \[m\].
const MAX_SIGMA: f64 = 1e4;

/// The pose of a level laser seen from above, and whether it is mounted upside down.
pub(super) fn planar_mounting(place: &Isometry3<f64>, frame: &str) -> Result<(Pose2, bool)> {
    let up = (place.rotation * Vector3::z()).z;
    if up.abs() < LEVEL {
        return Err(Error::Malformed {
            what: format!("frame {frame}"),
            expected: "a laser that is level to 10 degrees".into(),
            found: format!("one tilted by {:.1} degrees", up.clamp(-1.0, 1.0).acos().to_degrees()),
        });
    }
    let pose = messages::planar(place);
    Ok((Pose2::new(pose.x, pose.y, angle::wrap(pose.theta)), up < 0.0))
}

/// The scan as [`loc_sensors`] has it; one of a laser mounted upside down turns the other way.
pub(super) fn converted(message: &messages::LaserScan, upside_down: bool) -> Result<LaserScan> {
    let sign = if upside_down { -1.0 } else { 1.0 };
    let numbers = |values: &[f32]| values.iter().map(|value| f64::from(*value)).collect();
    let mut intensities: Vec<f64> = numbers(&message.intensities);
    if intensities.len() != message.ranges.len() {
        // Some drivers send a few of them; nothing here needs them.
        intensities.clear();
    }
    let converted = LaserScan {
        angle_min: sign * f64::from(message.angle_min),
        angle_max: sign * f64::from(message.angle_max),
        angle_increment: sign * f64::from(message.angle_increment),
        time_increment: message.time_increment.into(),
        scan_time: message.scan_time.into(),
        range_min: message.range_min.into(),
        range_max: message.range_max.into(),
        ranges: numbers(&message.ranges),
        intensities,
    };
    converted.check()?;
    Ok(converted)
}

/// A sample in the unit's own axes; `None` where the unit measures only half of it.
pub(super) fn inertial_sample(imu: &Imu) -> Result<Option<ImuReading>> {
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

/// The sample in the robot's axes, at its middle; `place` is `base_from_unit`.
pub(super) fn at_base(reading: &ImuReading, place: &Isometry3<f64>) -> ImuReading {
    let rate = place.rotation * reading.angular_velocity;
    let centripetal = rate.cross(&rate.cross(&place.translation.vector));
    let acceleration = place.rotation * reading.acceleration - centripetal;
    ImuReading { acceleration, angular_velocity: rate }
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
    let max = MAX_SIGMA * MAX_SIGMA;
    let symmetric = (covariance.m12 - covariance.m21).abs() <= 1e-6 * covariance.trace().abs();
    let within = |value: f64| value > 0.0 && value <= max;
    symmetric && within(covariance.m11) && within(covariance.m22) && covariance.determinant() > 0.0
}

/// An odometry that drifts away from the recorded one (E7): each step gets errors of distance and
/// heading whose variances grow with distance and rotation.
#[derive(Debug)]
pub(super) struct NoisyOdometry {
    noise: VelocityNoise,
    rng: ChaCha8Rng,
    /// The last pose as recorded, and with its noise.
    last: Option<(Pose2, Pose2)>,
}

impl NoisyOdometry {
    pub(super) fn new(noise: VelocityNoise, seed: u64) -> Self {
        NoisyOdometry { noise, rng: stream(seed, "odometry"), last: None }
    }

    /// The noisy pose in place of the next recorded one.
    pub(super) fn next(&mut self, recorded: Pose2) -> Pose2 {
        let noisy = match self.last {
            None => recorded,
            Some((before, noisy)) => noisy * self.disturbed(before.between(recorded)),
        };
        self.last = Some((recorded, noisy));
        noisy
    }

    /// A step with an error of its distance, and one of its heading that is spread evenly over the
    /// step: half of it acts at half of the distance.
    fn disturbed(&mut self, step: Pose2) -> Pose2 {
        let (distance, rotation) = (step.x.hypot(step.y), step.theta.abs());
        let mut normal = |variance: f64| {
            let unit: f64 = StandardNormal.sample(&mut self.rng);
            variance.sqrt() * unit
        };
        let along = normal(self.noise.k_d() * distance);
        let heading = normal(self.noise.k_theta() * rotation + self.noise.k_drift() * distance);
        let scale = if distance > 0.0 { 1.0 + along / distance } else { 1.0 };
        let (sin, cos) = (heading / 2.0).sin_cos();
        Pose2::new(
            scale * (cos * step.x - sin * step.y),
            scale * (sin * step.x + cos * step.y),
            angle::wrap(step.theta + heading),
        )
    }
}
