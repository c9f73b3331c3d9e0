//! Recordings of a robot that observes landmarks, for SLAM.
//!
//! The true landmarks of a recording go into the [`Setup`] for evaluation; methods of SLAM do not use
//! them. [`LandmarkRecording::course`] reads the landmark course of the Freiburg lectures,
//! [`kf_slam_demo`] the demonstration of MRPT, [`victoria_park`] the car in a park.

pub mod kf_slam_demo;
pub mod victoria_park;

pub use victoria_park::Trees;

use super::text::{not_empty, whole};
use super::{Setup, Source};
use crate::{Error, Result};
use loc_core::gaussian::pose_belief;
use loc_core::motion::OdometryMotion;
use loc_core::table::{Row, Table};
use loc_core::{Gaussian, Pose2};
use loc_maps::{Landmark, LandmarkMap};
use loc_sensors::event::{Control, Event, Measurement, Payload};
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use std::path::Path;
use std::sync::Arc;

/// A recording of odometry and observations of landmarks.
#[derive(Debug)]
pub struct LandmarkRecording {
    setup: Setup,
    mounting: Pose2,
    has_truth: bool,
    truth_has_heading: bool,
    events: std::vec::IntoIter<Event>,
    notes: Vec<String>,
}

/// The parts of a recording, read from its files.
struct Parts {
    name: String,
    /// The true landmarks; empty where unknown.
    landmarks: LandmarkMap,
    events: Vec<Event>,
    start: Pose2,
    /// The sensor's pose on the robot.
    mounting: Pose2,
    truth_has_heading: bool,
    notes: Vec<String>,
}

impl LandmarkRecording {
    /// `sigmas` are the standard deviations of the start over (x, y, heading) \[m, m, rad\].
    fn new(path: &Path, mut parts: Parts, sigmas: [f64; 3]) -> Result<Self> {
        parts.events.sort_by(Event::order);
        let stamps = || parts.events.iter().map(|event| event.stamp);
        let (first, last) = (stamps().reduce(f64::min), stamps().reduce(f64::max));
        let (Some(start), Some(end)) = (first, last) else {
            return Err(Error::Recording {
                path: path.to_owned(),
                expected: "odometry and observations".into(),
                found: "none".into(),
            });
        };
        let belief = pose_belief(parts.start, sigmas);
        let setup = Setup {
            name: parts.name,
            start,
            end,
            start_belief: Gaussian::new(belief.mean, belief.covariance)?,
            rail: None,
            landmarks: Arc::new(parts.landmarks),
            map: None,
            lines: None,
            has_laser: false,
            kidnapped_at: None,
        };
        let is_truth = |event: &Event| matches!(event.payload, Payload::Truth(_));
        Ok(LandmarkRecording {
            setup,
            mounting: parts.mounting,
            has_truth: parts.events.iter().any(is_truth),
            truth_has_heading: parts.truth_has_heading,
            events: parts.events.into_iter(),
            notes: parts.notes,
        })
    }

    /// The camera's pose on the robot, `base_from_camera`.
    pub fn mounting(&self) -> Pose2 {
        self.mounting
    }

    /// Opens a folder with the landmark course of the Freiburg lectures on robot mapping: a simulated
    /// robot among nine numbered landmarks.
    ///
    /// `sensor_data.dat` holds lines `ODOMETRY rot1 trans rot2` (rotation, translation, rotation) and
    /// `SENSOR id range bearing`; observations follow the motion before them. `world.dat` holds
    /// `id x y` for each landmark. The robot starts at the origin. There are no times and no true
    /// poses: a step counts as 1 s. Without `world.dat` the true landmarks are
    /// unknown. `sigmas` are the standard deviations of the start over (x, y, heading)
    /// \[m, m, rad\].
    ///
    /// # Errors
    /// [`loc_core::Error`] with file, line and column.
    pub fn course(folder: impl AsRef<Path>, sigmas: [f64; 3]) -> Result<Self> {
        let folder = folder.as_ref();
        let file = folder.join(LOG);
        let columns = ["kind", "rot1 or id", "trans or range", "rot2 or bearing"];
        let table = Table::read(&file, &columns)?;
        let (mut pose, mut step, mut seen) = (Pose2::IDENTITY, 0_u32, Vec::new());
        let (mut events, mut below_zero) = (vec![odometry(0.0, pose)], 0);
        for row in table.rows() {
            let row = row?;
            match row.text("kind")? {
                "ODOMETRY" => {
                    if !seen.is_empty() {
                        events.push(observations(f64::from(step), std::mem::take(&mut seen)));
                    }
                    pose = motion(&row)?.apply(pose);
                    step += 1;
                    events.push(odometry(f64::from(step), pose));
                }
                "SENSOR" => {
                    let range = row.number("trans or range")?;
                    below_zero += usize::from(range < 0.0);
                    let bearing = row.number("rot2 or bearing")?;
                    let observed = Observed::RangeBearing { range: range.max(0.0), bearing };
                    seen.push(LandmarkObservation {
                        landmark: whole(&row, "rot1 or id")?,
                        observed,
                    });
                }
                other => return Err(row.error("kind", "ODOMETRY or SENSOR", other).into()),
            }
        }
        not_empty(step == 0, &file, "motions (ODOMETRY)")?;
        if !seen.is_empty() {
            events.push(observations(f64::from(step), seen));
        }
        let mut notes = vec!["no times were recorded: a step is taken for a second".to_owned()];
        if below_zero > 0 {
            notes.push(format!("{below_zero} distances that noise has made negative taken for 0"));
        }
        let parts = Parts {
            name: folder_name(folder),
            landmarks: read_world(&folder.join("world.dat"))?,
            events,
            start: Pose2::IDENTITY,
            mounting: Pose2::IDENTITY,
            truth_has_heading: true,
            notes,
        };
        LandmarkRecording::new(folder, parts, sigmas)
    }
}

impl Source for LandmarkRecording {
    fn setup(&self) -> &Setup {
        &self.setup
    }

    fn next_event(&mut self) -> Result<Option<Event>> {
        Ok(self.events.next())
    }

    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    fn truth_has_heading(&self) -> bool {
        self.truth_has_heading
    }

    fn has_truth(&self) -> bool {
        self.has_truth
    }
}

fn odometry(stamp: f64, pose: Pose2) -> Event {
    Event::now(stamp, Payload::Control(Control::Odometry(pose)))
}

fn observations(stamp: f64, seen: Vec<LandmarkObservation>) -> Event {
    Event::now(stamp, Payload::Measurement(Measurement::Landmarks(seen)))
}

fn folder_name(folder: &Path) -> String {
    folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy().into_owned()
}

const LOG: &str = "sensor_data.dat";

/// Whether a folder looks like this recording.
pub fn is_course(folder: &Path) -> bool {
    folder.join(LOG).is_file()
}

fn motion(row: &Row<'_>) -> Result<OdometryMotion> {
    Ok(OdometryMotion {
        rot1: row.number("rot1 or id")?,
        trans: row.number("trans or range")?,
        rot2: row.number("rot2 or bearing")?,
    })
}

fn read_world(file: &Path) -> Result<LandmarkMap> {
    if !file.is_file() {
        return Ok(LandmarkMap::default());
    }
    let table = Table::read(file, &["id", "x", "y"])?;
    let mut landmarks = Vec::new();
    for row in table.rows() {
        let row = row?;
        landmarks.push(Landmark::planar(whole(&row, "id")?, row.number("x")?, row.number("y")?));
    }
    not_empty(landmarks.is_empty(), file, "landmarks")?;
    Ok(LandmarkMap::new(landmarks)?)
}
