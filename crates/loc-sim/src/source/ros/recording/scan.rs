//! The place of a laser, and its scans in the form of the library.

use crate::source::ros::messages;
use crate::{Error, Result};
use loc_core::nalgebra::{Isometry3, Vector3};
use loc_core::{Pose2, angle};
use loc_sensors::laser::LaserScan;

/// How far a laser may be tilted and still count as level: cos 10 degrees.
const LEVEL: f64 = 0.985;

/// The place of a level laser seen from above, and whether it hangs upside down.
pub(super) fn level(place: &Isometry3<f64>, frame: &str) -> Result<(Pose2, bool)> {
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

/// The library's form of a scan; one that hangs upside down turns the other way.
pub(super) fn converted(scan: &messages::LaserScan, upside_down: bool) -> Result<LaserScan> {
    let sign = if upside_down { -1.0 } else { 1.0 };
    let numbers = |values: &[f32]| values.iter().map(|value| f64::from(*value)).collect();
    let mut intensities: Vec<f64> = numbers(&scan.intensities);
    if intensities.len() != scan.ranges.len() {
        // Some drivers send a few of them; nothing here needs them.
        intensities.clear();
    }
    let converted = LaserScan {
        angle_min: sign * f64::from(scan.angle_min),
        angle_max: sign * f64::from(scan.angle_max),
        angle_increment: sign * f64::from(scan.angle_increment),
        time_increment: scan.time_increment.into(),
        scan_time: scan.scan_time.into(),
        range_min: scan.range_min.into(),
        range_max: scan.range_max.into(),
        ranges: numbers(&scan.ranges),
        intensities,
    };
    converted.check()?;
    Ok(converted)
}
