//! Recordings of a robot that measures distances to beacons: radio ranging and odometry.

pub mod labyrinth;
pub mod plaza;

use super::{Setup, Source};
use crate::{Error, Result};
use loc_core::gaussian::pose_belief;
use loc_core::{Gaussian, Pose2};
use loc_maps::LandmarkMap;
use loc_sensors::event::{Event, Measurement, Payload};
use loc_sensors::landmark_camera::{LandmarkNoise, LandmarkObservation, Observed};
use std::path::Path;
use std::sync::Arc;

/// The start of such a recording.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RangingStart {
    /// The start pose; that of the reference if `None`.
    pub pose: Option<Pose2>,
    /// Its standard deviations over (x, y, heading) \[m, m, rad\].
    pub sigmas: [f64; 3],
}

/// A recording of ranges to beacons at known positions.
#[derive(Debug)]
pub struct RangeRecording {
    setup: Setup,
    noise: LandmarkNoise,
    truth_has_heading: bool,
    events: std::vec::IntoIter<Event>,
    notes: Vec<String>,
}

/// The parts of a recording, read from its files.
struct Parts {
    name: String,
    beacons: LandmarkMap,
    events: Vec<Event>,
    /// The first pose of the reference.
    start: Pose2,
    truth_has_heading: bool,
    /// From the data sheet.
    range_sigma: f64,
    notes: Vec<String>,
}

impl RangeRecording {
    fn new(path: &Path, mut parts: Parts, start: &RangingStart) -> Result<Self> {
        parts.events.sort_by(Event::order);
        let stamps = || parts.events.iter().map(|event| event.stamp);
        let (first, last) = (stamps().reduce(f64::min), stamps().reduce(f64::max));
        let (Some(first), Some(last)) = (first, last) else {
            return Err(Error::Recording {
                path: path.to_owned(),
                expected: "ranges, odometry and true positions".into(),
                found: "none".into(),
            });
        };
        let belief = pose_belief(start.pose.unwrap_or(parts.start), start.sigmas);
        let setup = Setup {
            name: parts.name,
            start: first,
            end: last,
            start_belief: Gaussian::new(belief.mean, belief.covariance)?,
            rail: None,
            landmarks: Arc::new(parts.beacons),
            map: None,
            lines: None,
            has_laser: false,
            kidnapped_at: None,
        };
        Ok(RangeRecording {
            setup,
            noise: LandmarkNoise { range_sigma: parts.range_sigma, ..LandmarkNoise::default() },
            truth_has_heading: parts.truth_has_heading,
            events: parts.events.into_iter(),
            notes: parts.notes,
        })
    }

    /// Noise of the ranges by the data sheet of the radios.
    pub fn noise(&self) -> LandmarkNoise {
        self.noise
    }
}

impl Source for RangeRecording {
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
}

/// One range to a beacon.
fn range_event(stamp: f64, beacon: u32, range: f64) -> Event {
    let observation = LandmarkObservation { landmark: beacon, observed: Observed::Range { range } };
    Event::now(stamp, Payload::Measurement(Measurement::Landmarks(vec![observation])))
}
