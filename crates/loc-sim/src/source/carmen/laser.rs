//! Scans in a CARMEN log.

use crate::Result;
use crate::source::laser_log::Words;
use loc_core::Pose2;
use loc_sensors::laser::LaserScan;
use std::f64::consts::PI;

/// A scan with the poses that the log gives for it.
#[derive(Debug, Clone, PartialEq)]
pub struct CarmenLaser {
    /// Time of the scan \[s\].
    pub stamp: f64,
    /// The ranges, with +inf where nothing was in reach.
    pub scan: LaserScan,
    /// Pose of the laser: in a corrected log the reference, else the odometry.
    pub laser: Pose2,
    /// Pose of the robot in its odometry.
    pub robot: Pose2,
}

/// What the log's `PARAM` lines say about the front laser.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LaserParameters {
    /// Opening angle \[rad\].
    pub(super) fov: Option<f64>,
    /// From one beam to the next \[rad\].
    pub(super) resolution: Option<f64>,
    /// Readings from here on saw nothing \[m\].
    pub(super) max_range: f64,
    /// How far ahead of the robot's centre it sits \[m\].
    pub(super) offset: Option<f64>,
}

impl Default for LaserParameters {
    fn default() -> Self {
        // The scanners of these logs report 81.9 m, and some drivers 80 m, where nothing returns.
        LaserParameters { fov: None, resolution: None, max_range: 80.0, offset: None }
    }
}

/// `FLASER n r1 .. rn x y theta odom_x odom_y odom_theta ipc_time host logger_time`
pub(super) fn front_laser(words: &mut Words<'_>, given: &LaserParameters) -> Result<CarmenLaser> {
    let count = words.count("number of ranges", LaserScan::MAX_BEAMS)?;
    let ranges = words.numbers("range", count)?;
    let laser = words.pose("laser pose")?;
    let robot = words.pose("robot pose")?;
    let stamp = words.number("ipc_timestamp")?;
    // Half a turn, with a beam at both ends where their number is odd.
    let resolution = given.resolution.or_else(|| {
        let fov = given.fov.unwrap_or(PI);
        let steps = if count % 2 == 1 { count.saturating_sub(1).max(1) } else { count };
        (steps > 0).then(|| fov / steps as f64)
    });
    let start = -0.5 * given.fov.unwrap_or(PI);
    let scan = scan(words, ranges, start, resolution.unwrap_or(0.0), given.max_range)?;
    Ok(CarmenLaser { stamp, scan, laser, robot })
}

/// `ROBOTLASER1 type start_angle fov resolution max_range accuracy remission_mode n r1 .. rn m
/// s1 .. sm laser_x laser_y laser_theta robot_x robot_y robot_theta tv rv forward_safety_dist
/// side_safety_dist turn_axis ipc_time host logger_time`
pub(super) fn robot_laser(words: &mut Words<'_>) -> Result<CarmenLaser> {
    words.skip("laser type", 1)?;
    let start = words.number("start angle")?;
    words.skip("field of view", 1)?;
    let resolution = words.number("angular resolution")?;
    let max_range = words.number("maximum range")?;
    words.skip("accuracy and remission mode", 2)?;
    let count = words.count("number of ranges", LaserScan::MAX_BEAMS)?;
    let ranges = words.numbers("range", count)?;
    let remissions = words.count("number of remissions", LaserScan::MAX_BEAMS)?;
    words.skip("remission", remissions)?;
    let laser = words.pose("laser pose")?;
    let robot = words.pose("robot pose")?;
    words.skip("velocities and safety distances", 5)?;
    let stamp = words.number("ipc_timestamp")?;
    let scan = scan(words, ranges, start, resolution, max_range)?;
    Ok(CarmenLaser { stamp, scan, laser, robot })
}

fn scan(
    words: &Words<'_>,
    mut ranges: Vec<f64>,
    angle_min: f64,
    angle_increment: f64,
    range_max: f64,
) -> Result<LaserScan> {
    for range in &mut ranges {
        if *range >= range_max {
            *range = f64::INFINITY;
        }
    }
    let scan = LaserScan {
        angle_min,
        angle_max: angle_min + angle_increment * ranges.len().saturating_sub(1) as f64,
        angle_increment,
        time_increment: 0.0,
        scan_time: 0.0,
        range_min: 0.0,
        range_max,
        ranges,
        intensities: Vec::new(),
    };
    scan.check().map_err(|error| words.error("scan", "a scan", &error.to_string()))?;
    Ok(scan)
}
