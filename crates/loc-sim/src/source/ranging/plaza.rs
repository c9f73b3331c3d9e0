//! The Plaza recordings of CMU: a lawn mower among four radio beacons.
//!
//! A folder holds for each drive k `plazak_ranges.csv` (time, antenna, beacon, range),
//! `plazak_odometry.csv` (time, distance and turn since the line above), `plazak_beacons.csv` (number,
//! x, y) and `plazak_groundtruth.csv` (time, x, y, heading). Ranges are about 7 % too long. The
//! reference takes its positions from RTK GPS but its headings from the odometry, so heading
//! errors are the deviation of a method from odometry.

use super::{Parts, RangeRecording, RangingStart, range_event};
use crate::source::text::{distance, not_empty, stamp_after, whole};
use crate::{Error, Result};
use loc_core::table::Table;
use loc_core::{Pose2, Twist2};
use loc_maps::{Landmark, LandmarkMap};
use loc_sensors::event::{Control, Event, Payload, Truth};
use std::path::Path;

/// Standard deviation of the radios' ranges without their bias \[m\].
const RANGE_SIGMA: f64 = 0.5;

/// Whether a folder looks like these recordings.
pub fn is_plaza(folder: &Path) -> bool {
    drives(folder).next().is_some()
}

/// The numbers of the drives in a folder.
fn drives(folder: &Path) -> impl Iterator<Item = u32> {
    (1..=9).filter(|k| folder.join(format!("plaza{k}_ranges.csv")).is_file())
}

impl RangeRecording {
    /// Opens drive `drive` of a folder of Plaza recordings.
    ///
    /// # Errors
    /// [`loc_core::Error`] with file, line and column; [`Error::Recording`] for a drive that is
    /// not there.
    pub fn plaza(folder: impl AsRef<Path>, drive: u32, start: &RangingStart) -> Result<Self> {
        let folder = folder.as_ref();
        let file = |part: &str| folder.join(format!("plaza{drive}_{part}.csv"));
        if folder.is_dir() && !file("ranges").is_file() {
            let known: Vec<String> = drives(folder).map(|k| k.to_string()).collect();
            return Err(Error::Recording {
                path: folder.to_owned(),
                expected: format!("one of the drives {}", known.join(", ")),
                found: format!("drive {drive}"),
            });
        }
        let (ranges, late) = read_ranges(&file("ranges"))?;
        let beacons = read_beacons(&file("beacons"))?;
        let truth = read_truth(&file("groundtruth"))?;
        let start_pose = truth.first().map_or(Pose2::IDENTITY, |(_, pose)| *pose);
        let begin = truth.first().map_or(0.0, |(stamp, _)| *stamp);
        let mut events = read_odometry(&file("odometry"), begin)?;
        events.extend(ranges);
        events.extend(
            truth.iter().map(|&(stamp, pose)| {
                Event::now(stamp, Payload::Truth(Truth { pose, speed: None }))
            }),
        );
        events.retain(|event| event.stamp >= begin);
        let note = format!("{late} ranges stand behind later ones in the file; sorted by stamp");
        let parts = Parts {
            name: format!("plaza {drive}"),
            beacons,
            events,
            start: start_pose,
            truth_has_heading: true,
            range_sigma: RANGE_SIGMA,
            notes: if late > 0 { vec![note] } else { Vec::new() },
        };
        RangeRecording::new(folder, parts, start)
    }
}

fn read_beacons(file: &Path) -> Result<LandmarkMap> {
    let table = Table::read(file, &["beacon_id", "x_m", "y_m"])?;
    let mut beacons = Vec::new();
    for row in table.rows() {
        let row = row?;
        let id = whole(&row, "beacon_id")?;
        beacons.push(Landmark::planar(id, row.number("x_m")?, row.number("y_m")?));
    }
    not_empty(beacons.is_empty(), file, "beacons")?;
    Ok(LandmarkMap::new(beacons)?)
}

/// The ranges in file order, and the number of those out of order.
fn read_ranges(file: &Path) -> Result<(Vec<Event>, usize)> {
    let table = Table::read(file, &["time_s", "antenna_id", "beacon_id", "range_m"])?;
    let (mut events, mut late, mut latest) = (Vec::new(), 0, f64::NEG_INFINITY);
    for row in table.rows() {
        let row = row?;
        let stamp = row.number("time_s")?;
        late += usize::from(stamp < latest);
        latest = latest.max(stamp);
        events.push(range_event(stamp, whole(&row, "beacon_id")?, distance(&row, "range_m")?));
    }
    not_empty(events.is_empty(), file, "ranges")?;
    Ok((events, late))
}

/// Velocities from one line to the next, each known at its end.
fn read_odometry(file: &Path, begin: f64) -> Result<Vec<Event>> {
    let table = Table::read(file, &["time_s", "delta_distance_m", "delta_heading_rad"])?;
    let (mut events, mut before, mut last) = (Vec::new(), begin, f64::NEG_INFINITY);
    for row in table.rows() {
        let row = row?;
        let stamp = stamp_after(&row, "time_s", &mut last)?;
        let dt = stamp - before;
        let (way, turn) = (row.number("delta_distance_m")?, row.number("delta_heading_rad")?);
        if dt > 0.0 {
            let velocity = Control::Velocity(Twist2::forward(way / dt, turn / dt));
            let payload = Payload::Control(velocity);
            events.push(Event { stamp: before, arrival: stamp, payload });
            before = stamp;
        }
    }
    not_empty(events.is_empty(), file, "odometry")?;
    // After the last line the robot is at rest.
    let payload = Payload::Control(Control::Velocity(Twist2::ZERO));
    events.push(Event::now(before, payload));
    Ok(events)
}

fn read_truth(file: &Path) -> Result<Vec<(f64, Pose2)>> {
    let table = Table::read(file, &["time_s", "x_m", "y_m", "theta_rad"])?;
    let (mut poses, mut last) = (Vec::new(), f64::NEG_INFINITY);
    for row in table.rows() {
        let row = row?;
        let stamp = stamp_after(&row, "time_s", &mut last)?;
        let pose = Pose2::new(row.number("x_m")?, row.number("y_m")?, row.number("theta_rad")?);
        poses.push((stamp, pose));
    }
    not_empty(poses.is_empty(), file, "true poses")?;
    Ok(poses)
}
