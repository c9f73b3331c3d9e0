//! The UTIAS MRCLAM recordings: robots among landmarks with barcodes, followed by a Vicon system.
//!
//! A folder holds `Barcodes.dat` (subject, barcode), `Landmark_Groundtruth.dat` (subject, x, y and
//! their deviations) and for each robot k `Robotk_Odometry.dat` (t, v, omega),
//! `Robotk_Measurement.dat` (t, barcode, range, bearing) and `Robotk_Groundtruth.dat` (t, x, y,
//! theta). Subjects 1 to 5 are the robots themselves; observations of
//! them and of unknown barcodes are skipped.

use super::{Setup, Source};
use crate::{Error, Result};
use loc_core::table::{Row, Table};
use loc_core::{Gaussian, Pose2, Trajectory, Twist2};
use loc_maps::{Landmark, LandmarkMap};
use loc_sensors::event::{Control, Event, Measurement, Payload, Truth};
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// Longest gap of the truth that is interpolated for the start pose \[s\].
const LONGEST_GAP: f64 = 0.5;

/// Highest subject number that is a robot.
const LAST_ROBOT: u32 = 5;

/// One robot of an MRCLAM recording.
#[derive(Debug)]
pub struct Mrclam {
    setup: Setup,
    events: std::vec::IntoIter<Event>,
    unknown_barcodes: usize,
    robots_seen: usize,
}

/// Whether a folder looks like an MRCLAM recording.
pub fn is_mrclam(folder: &Path) -> bool {
    folder.join("Barcodes.dat").is_file()
}

impl Mrclam {
    /// Opens the recording of robot `robot`, counted from 1. The start pose is the true one.
    ///
    /// # Errors
    /// [`loc_core::Error`] with file, line and column; [`Error::Recording`] where the parts do not
    /// fit together.
    pub fn open(folder: impl AsRef<Path>, robot: u32) -> Result<Self> {
        let folder = folder.as_ref();
        let file = |part: &str| folder.join(format!("Robot{robot}_{part}.dat"));
        if folder.is_dir() && !file("Odometry").is_file() {
            return Err(no_such_robot(folder, robot));
        }
        let subjects = read_barcodes(&folder.join("Barcodes.dat"))?;
        let landmarks = read_landmarks(&folder.join("Landmark_Groundtruth.dat"))?;
        let odometry = read_odometry(&file("Odometry"))?;
        let truth = read_truth(&file("Groundtruth"))?;
        let observations = read_measurements(&file("Measurement"))?;

        let (start, start_pose) = common_start(folder, &odometry, &truth)?;
        let end = odometry.last().map_or(start, |event| event.stamp);
        let mut recording = Mrclam {
            setup: Setup {
                name: format!("{} robot {robot}", folder_name(folder)),
                start,
                end,
                start_belief: Gaussian::certain(start_pose.to_vector()),
                rail: None,
                landmarks: Arc::new(landmarks),
                map: None,
                lines: None,
                has_laser: false,
                kidnapped_at: None,
            },
            events: Vec::new().into_iter(),
            unknown_barcodes: 0,
            robots_seen: 0,
        };
        let mut events = odometry;
        events.extend(recording.name_landmarks(observations, &subjects));
        events.extend(truth.iter().map(|pose| {
            let truth = Truth { pose: pose.value, speed: None };
            Event::now(pose.stamp, Payload::Truth(truth))
        }));
        events.retain(|event| event.stamp >= start);
        events.sort_by(Event::order);
        recording.events = events.into_iter();
        Ok(recording)
    }

    /// Turns barcodes into landmark numbers, counts the others, and puts the observations of one
    /// stamp together.
    fn name_landmarks(
        &mut self,
        seen: Vec<(f64, u32, Observed)>,
        subjects: &HashMap<u32, u32>,
    ) -> Vec<Event> {
        let mut events: Vec<Event> = Vec::new();
        for (stamp, barcode, observed) in seen {
            let landmark = match subjects.get(&barcode) {
                None => {
                    self.unknown_barcodes += 1;
                    continue;
                }
                Some(&subject) if subject <= LAST_ROBOT => {
                    self.robots_seen += 1;
                    continue;
                }
                Some(&subject) => subject,
            };
            let observation = LandmarkObservation { landmark, observed };
            match events.last_mut() {
                Some(Event {
                    stamp: last,
                    payload: Payload::Measurement(Measurement::Landmarks(group)),
                    ..
                }) if *last >= stamp => group.push(observation),
                _ => {
                    let measurement = Measurement::Landmarks(vec![observation]);
                    events.push(Event::now(stamp, Payload::Measurement(measurement)));
                }
            }
        }
        events
    }
}

impl Source for Mrclam {
    fn setup(&self) -> &Setup {
        &self.setup
    }

    fn next_event(&mut self) -> Result<Option<Event>> {
        Ok(self.events.next())
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.unknown_barcodes > 0 {
            notes.push(format!(
                "{} observations of unknown barcodes passed over",
                self.unknown_barcodes
            ));
        }
        if self.robots_seen > 0 {
            notes.push(format!("{} observations of other robots passed over", self.robots_seen));
        }
        notes
    }
}

/// subject -> barcode lines, as a map from barcode to subject.
fn read_barcodes(file: &Path) -> Result<HashMap<u32, u32>> {
    let table = Table::read(file, &["subject", "barcode"])?;
    let mut subjects = HashMap::new();
    for row in table.rows() {
        let row = row?;
        let barcode = row.whole_number("barcode")?;
        if subjects.insert(barcode, row.whole_number("subject")?).is_some() {
            let expected = "a barcode that no other subject wears";
            return Err(row.error("barcode", expected, &barcode.to_string()).into());
        }
    }
    not_empty(subjects.is_empty(), file, "barcodes")?;
    Ok(subjects)
}

fn read_landmarks(file: &Path) -> Result<LandmarkMap> {
    let table = Table::read(file, &["subject", "x", "y", "x_sigma", "y_sigma"])?;
    let mut landmarks = Vec::new();
    for row in table.rows() {
        let row = row?;
        let id = row.whole_number("subject")?;
        landmarks.push(Landmark::planar(id, row.number("x")?, row.number("y")?));
    }
    not_empty(landmarks.is_empty(), file, "landmarks")?;
    Ok(LandmarkMap::new(landmarks)?)
}

fn read_odometry(file: &Path) -> Result<Vec<Event>> {
    let table = Table::read(file, &["time", "v", "omega"])?;
    let mut events = Vec::new();
    let mut last = f64::NEG_INFINITY;
    for row in table.rows() {
        let row = row?;
        let stamp = stamp_after(&row, &mut last)?;
        let twist = Twist2::forward(row.number("v")?, row.number("omega")?);
        events.push(Event::now(stamp, Payload::Control(Control::Velocity(twist))));
    }
    not_empty(events.is_empty(), file, "odometry")?;
    Ok(events)
}

fn read_truth(file: &Path) -> Result<Trajectory> {
    let table = Table::read(file, &["time", "x", "y", "theta"])?;
    let mut truth = Trajectory::new();
    let mut last = f64::NEG_INFINITY;
    for row in table.rows() {
        let row = row?;
        let stamp = stamp_after(&row, &mut last)?;
        let pose = Pose2::new(row.number("x")?, row.number("y")?, row.number("theta")?);
        truth.push(stamp, pose)?;
    }
    not_empty(truth.is_empty(), file, "poses")?;
    Ok(truth)
}

fn read_measurements(file: &Path) -> Result<Vec<(f64, u32, Observed)>> {
    let table = Table::read(file, &["time", "barcode", "range", "bearing"])?;
    let mut seen = Vec::new();
    let mut last = f64::NEG_INFINITY;
    for row in table.rows() {
        let row = row?;
        let stamp = stamp_after(&row, &mut last)?;
        let range = row.number("range")?;
        if range < 0.0 {
            return Err(row.error("range", "a distance >= 0", row.text("range")?).into());
        }
        let observed = Observed::RangeBearing { range, bearing: row.number("bearing")? };
        seen.push((stamp, row.whole_number("barcode")?, observed));
    }
    not_empty(seen.is_empty(), file, "measurements")?;
    Ok(seen)
}

/// The stamp of a row, which must not be before that of the row above.
fn stamp_after(row: &Row<'_>, last: &mut f64) -> Result<f64> {
    let stamp = row.number("time")?;
    if stamp < *last {
        let expected = format!("a time not before {last}, that of the line above");
        return Err(row.error("time", &expected, row.text("time")?).into());
    }
    *last = stamp;
    Ok(stamp)
}

fn not_empty(empty: bool, file: &Path, what: &'static str) -> Result<()> {
    if empty {
        return Err(loc_core::Error::Empty { file: file.to_owned(), what }.into());
    }
    Ok(())
}

/// The first time that both odometry and truth cover, with the true pose.
fn common_start(folder: &Path, odometry: &[Event], truth: &Trajectory) -> Result<(f64, Pose2)> {
    let candidates = odometry.iter().map(|event| event.stamp);
    let first_truth = truth.first().map_or(f64::INFINITY, |pose| pose.stamp);
    candidates
        .filter(|stamp| *stamp >= first_truth)
        .find_map(|stamp| truth.interpolate(stamp, LONGEST_GAP).map(|pose| (stamp, pose)))
        .ok_or_else(|| Error::Recording {
            path: folder.to_owned(),
            expected: "odometry and truth that overlap in time".into(),
            found: "none that do".into(),
        })
}

fn no_such_robot(folder: &Path, robot: u32) -> Error {
    let known: Vec<String> = (1..=99)
        .filter(|k| folder.join(format!("Robot{k}_Odometry.dat")).is_file())
        .map(|k: u32| k.to_string())
        .collect();
    Error::Recording {
        path: folder.to_owned(),
        expected: format!("one of the robots {}", known.join(", ")),
        found: format!("robot {robot}"),
    }
}

fn folder_name(folder: &Path) -> String {
    folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy().into_owned()
}
