//! Recordings of a robot that sees landmarks, for drawing maps of them.
//!
//! What a map of the recording says about landmarks goes into the [`Setup`], to be compared with
//! in the end; methods of SLAM are not told.

pub mod course;
pub mod kf_slam_demo;
pub mod victoria_park;

pub use victoria_park::Trees;

use super::{Setup, Source};
use crate::{Error, Result};
use loc_core::gaussian::pose_belief;
use loc_core::{Gaussian, Pose2};
use loc_maps::LandmarkMap;
use loc_sensors::event::{Control, Event, Measurement, Payload};
use loc_sensors::landmark_camera::LandmarkObservation;
use std::path::Path;
use std::sync::Arc;

/// A recording of odometry and sighted landmarks.
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
    /// Where the landmarks really are; empty where nobody knows.
    landmarks: LandmarkMap,
    events: Vec<Event>,
    start: Pose2,
    /// The sensor's pose on the robot.
    mounting: Pose2,
    truth_has_heading: bool,
    notes: Vec<String>,
}

impl LandmarkRecording {
    /// `sigmas` tell how well the start pose is known, over (x, y, heading) \[m, m, rad\].
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

    /// Where the sensor that sees landmarks sits on the robot, `base_from_camera`.
    pub fn mounting(&self) -> Pose2 {
        self.mounting
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
