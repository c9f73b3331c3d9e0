//! The demonstration of SLAM that comes with MRPT, as text: a simulated robot among 70 landmarks.
//!
//! `*_bearing_range.csv` holds (step, time, landmark, range, yaw, pitch, deviations),
//! `*_odometry.csv` the motion (x, y, phi) that leads to each step, `*_ground_truth.txt` the
//! landmarks (x, y, z, .., number) and `*_ground_truth_robot_path.txt` a true pose
//! (x, y, z, yaw, pitch, roll) for each step. Steps have no times: each counts as 1 s.

use super::{LandmarkRecording, Parts, observations, odometry};
use crate::source::text::{distance, not_empty, whole};
use crate::{Error, Result};
use loc_core::Pose2;
use loc_core::table::Table;
use loc_maps::{Landmark, LandmarkMap};
use loc_sensors::event::{Event, Payload, Truth};
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Ending of the name of the file with the observations.
const OBSERVATIONS: &str = "_bearing_range.csv";

/// The column with the number of the landmark.
const NUMBER: &str = "landmark_id(-1=unknown)";

/// The number of an unknown landmark.
const UNKNOWN: &str = "-1";

/// The file with the observations: the given one, or the one in the given folder.
fn observations_file(path: &Path) -> Option<PathBuf> {
    let fits = |file: &PathBuf| file.to_string_lossy().ends_with(OBSERVATIONS);
    if path.is_dir() {
        let names = std::fs::read_dir(path).ok()?.filter_map(|entry| Some(entry.ok()?.path()));
        return names.filter(fits).min();
    }
    Some(path.to_owned()).filter(fits)
}

/// Whether a folder, or a file, looks like this recording.
pub fn is_kf_slam_demo(path: &Path) -> bool {
    observations_file(path).is_some()
}

impl LandmarkRecording {
    /// Opens the recording from its folder or from its file of observations. Without the
    /// files of true landmarks, or of the true path, these are unknown. `sigmas` are the standard
    /// deviations of the start over (x, y, heading) \[m, m, rad\].
    ///
    /// # Errors
    /// [`loc_core::Error`] with file, line and column; [`Error::Recording`] for another folder.
    pub fn kf_slam_demo(path: impl AsRef<Path>, sigmas: [f64; 3]) -> Result<Self> {
        let path = path.as_ref();
        let seen = observations_file(path).ok_or_else(|| Error::Recording {
            path: path.to_owned(),
            expected: format!("a file *{OBSERVATIONS}"),
            found: "none".into(),
        })?;
        let text = seen.to_string_lossy();
        let stem = text.strip_suffix(OBSERVATIONS).unwrap_or(&text).to_owned();
        let part = |ending: &str| PathBuf::from(format!("{stem}{ending}"));
        let truth = read_path(&part("_ground_truth_robot_path.txt"))?;
        let mut events = read_odometry(&part("_odometry.csv"))?;
        let (groups, unknown) = read_observations(&seen)?;
        events.extend(groups.into_iter().map(|(step, seen)| observations(f64::from(step), seen)));
        let start = truth.first().copied().unwrap_or(Pose2::IDENTITY);
        events.extend(truth.into_iter().zip(0_u32..).map(|(pose, step)| {
            Event::now(f64::from(step), Payload::Truth(Truth { pose, speed: None }))
        }));
        let mut notes = vec!["no times were recorded: a step is taken for a second".to_owned()];
        if unknown > 0 {
            notes.push(format!("{unknown} observations of unknown landmarks passed over"));
        }
        let name = Path::new(&stem).file_name().unwrap_or_default().to_string_lossy().into_owned();
        let parts = Parts {
            name,
            landmarks: read_landmarks(&part("_ground_truth.txt"))?,
            events,
            start,
            mounting: Pose2::IDENTITY,
            truth_has_heading: true,
            notes,
        };
        LandmarkRecording::new(path, parts, sigmas)
    }
}

/// Poses of the odometry, from the origin.
fn read_odometry(file: &Path) -> Result<Vec<Event>> {
    let table = Table::read(file, &["step", "time", "kind", "x", "y", "phi"])?;
    let (mut pose, mut events, mut last) = (Pose2::IDENTITY, Vec::new(), None);
    events.push(odometry(0.0, pose));
    for row in table.rows() {
        let row = row?;
        let step = whole(&row, "step")?;
        if last.is_some_and(|last| step <= last) || step == 0 {
            let expected = "a number above that of the line before";
            return Err(row.error("step", expected, row.text("step")?).into());
        }
        last = Some(step);
        if row.text("kind")? != "inc" {
            return Err(row.error("kind", "inc, a motion", row.text("kind")?).into());
        }
        pose = pose * Pose2::new(row.number("x")?, row.number("y")?, row.number("phi")?);
        events.push(odometry(f64::from(step), pose));
    }
    not_empty(last.is_none(), file, "motions")?;
    Ok(events)
}

/// The observations of each step, and how many have no number.
fn read_observations(file: &Path) -> Result<(BTreeMap<u32, Vec<LandmarkObservation>>, usize)> {
    let columns = ["step", "time", NUMBER, "range", "yaw", "pitch", "std_range", "std_yaw"];
    let table = Table::read(file, &columns)?;
    let (mut groups, mut unknown): (BTreeMap<u32, Vec<LandmarkObservation>>, usize) =
        Default::default();
    for row in table.rows() {
        let row = row?;
        let observed =
            Observed::RangeBearing { range: distance(&row, "range")?, bearing: row.number("yaw")? };
        if row.text(NUMBER)? == UNKNOWN {
            unknown += 1;
            continue;
        }
        let landmark = whole(&row, NUMBER)?;
        groups
            .entry(whole(&row, "step")?)
            .or_default()
            .push(LandmarkObservation { landmark, observed });
    }
    not_empty(groups.is_empty(), file, "observations")?;
    Ok((groups, unknown))
}

fn read_landmarks(file: &Path) -> Result<LandmarkMap> {
    if !file.is_file() {
        return Ok(LandmarkMap::default());
    }
    let table = Table::read(file, &["x", "y", "z", "a", "b", "c", "number"])?;
    let mut landmarks = Vec::new();
    for row in table.rows() {
        let row = row?;
        let id = whole(&row, "number")?;
        landmarks.push(Landmark::planar(id, row.number("x")?, row.number("y")?));
    }
    Ok(LandmarkMap::new(landmarks)?)
}

fn read_path(file: &Path) -> Result<Vec<Pose2>> {
    if !file.is_file() {
        return Ok(Vec::new());
    }
    let text = std::fs::read_to_string(file).map_err(loc_core::Error::io(file))?;
    // Comments begin with %.
    let without = |line: &str| if line.starts_with('%') { String::new() } else { line.to_owned() };
    let lines: Vec<String> = text.lines().map(without).collect();
    let columns = ["x", "y", "z", "yaw", "pitch", "roll"];
    let table = Table::parse(file, lines.join("\n"), &columns);
    let mut poses = Vec::new();
    for row in table.rows() {
        let row = row?;
        poses.push(Pose2::new(row.number("x")?, row.number("y")?, row.number("yaw")?));
    }
    Ok(poses)
}
