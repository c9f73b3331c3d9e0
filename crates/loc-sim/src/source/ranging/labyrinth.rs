//! The labyrinth recording of TU Chemnitz, in the text format of libRSF: a small robot among four
//! ultra-wideband anchors.
//!
//! `*_Input.txt` holds lines `range2` (time, range, variance, anchor x, y, number, signal) and
//! `odom2diff` (time, speeds of the two wheels and sideways, half the track, variances);
//! `*_GT.txt` lines `point2` (time, x, y, covariance). The description names the right wheel first
//! and calls the last of the lengths the distance between the wheels; only the left wheel
//! first and half that distance agree with the true path. No true heading was recorded.

use super::{Parts, RangeRecording, RangingStart, range_event};
use crate::source::text::{distance, not_empty, stamp_after, whole};
use crate::{Error, Result};
use loc_core::kinematics::Differential;
use loc_core::motion::Integration;
use loc_core::table::Table;
use loc_core::{Pose2, Stamped, Twist2, angle};
use loc_maps::{Landmark, LandmarkMap};
use loc_sensors::event::{Control, Event, Payload, Truth};
use nalgebra::Point2;
use std::path::{Path, PathBuf};

/// Distance along which the direction determines the start heading \[m\].
const FIRST_SEGMENT: f64 = 0.3;

/// The file with the sensors' lines in a folder of this kind.
fn input(folder: &Path) -> Option<PathBuf> {
    let names = std::fs::read_dir(folder).ok()?.filter_map(|entry| Some(entry.ok()?.path()));
    let is_input = |file: &PathBuf| {
        file.file_name().is_some_and(|name| name.to_string_lossy().ends_with("_Input.txt"))
    };
    names.filter(is_input).min()
}

/// Whether a folder looks like this recording.
pub fn is_labyrinth(folder: &Path) -> bool {
    input(folder).is_some()
}

impl RangeRecording {
    /// Opens a folder with the labyrinth recording.
    ///
    /// # Errors
    /// [`loc_core::Error`] with file, line and column; [`Error::Recording`] where the parts do not
    /// fit together.
    pub fn labyrinth(folder: impl AsRef<Path>, start: &RangingStart) -> Result<Self> {
        let folder = folder.as_ref();
        let input = input(folder).ok_or_else(|| Error::Recording {
            path: folder.to_owned(),
            expected: "a file *_Input.txt".into(),
            found: "none".into(),
        })?;
        let truth = PathBuf::from(input.to_string_lossy().replace("_Input.txt", "_GT.txt"));
        let (ranges, beacons, range_sigma) = read_ranges(&input)?;
        let velocities = read_odometry(&input)?;
        let positions = read_truth(&truth)?;
        let pose = start_pose(&positions, &velocities);
        let control = |control: &Stamped<Twist2>| {
            Event::now(control.stamp, Payload::Control(Control::Velocity(control.value)))
        };
        let seen = |point: &Stamped<Point2<f64>>| {
            let pose = Pose2::new(point.value.x, point.value.y, 0.0);
            Event::now(point.stamp, Payload::Truth(Truth { pose, speed: None }))
        };
        let mut events = ranges;
        events.extend(velocities.iter().map(control));
        events.extend(positions.iter().map(seen));
        let parts = Parts {
            name: folder_name(folder),
            beacons,
            events,
            start: pose,
            truth_has_heading: false,
            range_sigma,
            notes: vec![
                "no true heading is known: errors are of the position, a consistent NEES is 2"
                    .into(),
            ],
        };
        RangeRecording::new(folder, parts, start)
    }
}

/// The lines of one kind of a file, at their line numbers.
fn table(file: &Path, kind: &str, columns: &[&str]) -> Result<Table> {
    let text = std::fs::read_to_string(file).map_err(loc_core::Error::io(file))?;
    let mut of_kind = String::with_capacity(text.len());
    for line in text.lines() {
        if line.split_whitespace().next() == Some(kind) {
            of_kind.push_str(line);
        }
        of_kind.push('\n');
    }
    Ok(Table::parse(file, of_kind, columns))
}

/// Ranges, the anchors that they name, and their standard deviation \[m\].
fn read_ranges(file: &Path) -> Result<(Vec<Event>, LandmarkMap, f64)> {
    let columns = ["kind", "time", "range", "variance", "x", "y", "anchor", "signal"];
    let table = table(file, "range2", &columns)?;
    let (mut events, mut anchors): (Vec<Event>, Vec<Landmark>) = Default::default();
    let (mut variance, mut last) = (0.0, f64::NEG_INFINITY);
    for row in table.rows() {
        let row = row?;
        let stamp = stamp_after(&row, "time", &mut last)?;
        let (x, y) = (row.number("x")?, row.number("y")?);
        let anchor = Landmark::planar(whole(&row, "anchor")?, x, y);
        match anchors.iter().find(|known| known.id == anchor.id) {
            None => anchors.push(anchor),
            Some(known) if *known == anchor => {}
            Some(known) => {
                let (x, y) = (known.position.x, known.position.y);
                let expected = format!("the place ({x}, {y}) that anchor {} has above", anchor.id);
                return Err(row.error("x", &expected, row.text("x")?).into());
            }
        }
        variance += distance(&row, "variance")?;
        events.push(range_event(stamp, anchor.id, distance(&row, "range")?));
    }
    not_empty(events.is_empty(), file, "ranges (range2)")?;
    let sigma = (variance / events.len() as f64).sqrt();
    Ok((events, LandmarkMap::new(anchors)?, sigma))
}

fn read_odometry(file: &Path) -> Result<Vec<Stamped<Twist2>>> {
    let columns = ["kind", "time", "left", "right", "sideways", "half_track", "a", "b", "c"];
    let table = table(file, "odom2diff", &columns)?;
    let (mut velocities, mut last) = (Vec::new(), f64::NEG_INFINITY);
    for row in table.rows() {
        let row = row?;
        let stamp = stamp_after(&row, "time", &mut last)?;
        let drive = Differential::new(2.0 * row.number("half_track")?)?;
        let mut twist = drive.twist(row.number("left")?, row.number("right")?);
        twist.vy = row.number("sideways")?;
        velocities.push(Stamped { stamp, value: twist });
    }
    not_empty(velocities.is_empty(), file, "odometry (odom2diff)")?;
    Ok(velocities)
}

fn read_truth(file: &Path) -> Result<Vec<Stamped<Point2<f64>>>> {
    let columns = ["kind", "time", "x", "y", "xx", "xy", "yx", "yy"];
    let table = table(file, "point2", &columns)?;
    let (mut positions, mut last) = (Vec::new(), f64::NEG_INFINITY);
    for row in table.rows() {
        let row = row?;
        let stamp = stamp_after(&row, "time", &mut last)?;
        let value = Point2::new(row.number("x")?, row.number("y")?);
        positions.push(Stamped { stamp, value });
    }
    not_empty(positions.is_empty(), file, "true positions (point2)")?;
    Ok(positions)
}

/// The first true position, with the heading that aligns the odometry with the truth: the
/// directions of the first segment are compared.
fn start_pose(positions: &[Stamped<Point2<f64>>], velocities: &[Stamped<Twist2>]) -> Pose2 {
    let Some(first) = positions.first() else { return Pose2::IDENTITY };
    let moved = positions.iter().map(|p| (p.stamp, p.value - first.value));
    let heading =
        moved.filter(|(_, moved)| moved.norm() >= FIRST_SEGMENT).find_map(|(stamp, moved)| {
            let odometry = dead_reckoned(velocities, stamp).position();
            let far = odometry.coords.norm() >= 0.5 * FIRST_SEGMENT;
            far.then(|| angle::difference(moved.y.atan2(moved.x), odometry.y.atan2(odometry.x)))
        });
    Pose2::new(first.value.x, first.value.y, heading.unwrap_or(0.0))
}

/// Dead reckoning from the origin.
fn dead_reckoned(velocities: &[Stamped<Twist2>], until: f64) -> Pose2 {
    let mut pose = Pose2::IDENTITY;
    for (k, control) in velocities.iter().enumerate() {
        let end = velocities.get(k + 1).map_or(until, |next| next.stamp.min(until));
        if end > control.stamp {
            pose = Integration::ExactArc.step(pose, control.value, end - control.stamp);
        }
    }
    pose
}

fn folder_name(folder: &Path) -> String {
    folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy().into_owned()
}
