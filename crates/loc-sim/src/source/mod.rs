//! Sources of events: simulated robots and recordings.
//!
//! Every source implements [`Source`]: it yields [`Event`]s in order of arrival. A new log format is
//! one file here; a log with a laser only fills a [`laser_log::LaserLog`].

mod calibrated;
pub mod carmen;
pub mod drive;
pub mod landmarks;
pub mod laser_log;
pub mod mrclam;
pub mod outdoor;
pub mod people;
pub mod rail;
pub mod ranging;
pub mod ros;
pub mod text;
pub mod tour;
pub mod wean;

pub use calibrated::Calibrated;
pub use drive::SimulatedDrive;
pub use landmarks::LandmarkRecording;
pub use laser_log::LaserRecording;
pub use mrclam::Mrclam;
pub use outdoor::SimulatedOutdoor;
pub use rail::SimulatedRail;
pub use ranging::RangeRecording;
pub use ros::RosRecording;
pub use tour::SimulatedTour;

use crate::Result;
use loc_core::error::non_negative;
use loc_core::{Gaussian, Pose2, Twist2};
use loc_maps::{LandmarkMap, LineMap, OccupancyGrid};
use loc_sensors::event::{Control, Event};
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::sync::Arc;

/// What is known before the first event.
#[derive(Debug, Clone)]
pub struct Setup {
    /// Name of the recording or scenario, for headings.
    pub name: String,
    /// When the run starts \[s\].
    pub start: f64,
    /// When it ends, as far as is known \[s\].
    pub end: f64,
    /// Initial pose distribution.
    pub start_belief: Gaussian<3>,
    /// Initial distribution of position and speed of a vehicle on a rail.
    pub rail: Option<Gaussian<2>>,
    /// Landmarks at known positions; empty where there are none.
    pub landmarks: Arc<LandmarkMap>,
    /// The map of the surroundings, where there is one.
    pub map: Option<Arc<OccupancyGrid>>,
    /// The walls as lines, where such a map exists.
    pub lines: Option<Arc<LineMap>>,
    /// Whether a laser reports scans.
    pub has_laser: bool,
    /// When the robot is kidnapped \[s\]: from then on it is at another pose.
    pub kidnapped_at: Option<f64>,
}

/// The true errors of a simulated robot's sensors, for figures.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SensorTruth {
    /// Outages of sensors.
    pub silences: Vec<Silence>,
    /// The systematic errors.
    pub errors: Vec<TrueError>,
}

/// A time without measurements of a sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Silence {
    /// The sensor.
    pub sensor: &'static str,
    /// Its begin \[s\].
    pub from: f64,
    /// Its end \[s\].
    pub to: f64,
}

/// A true error over time, named as [`SensorError`](loc_filters::localizer::SensorError) names it.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueError {
    /// The sensor with the unit of the error.
    pub name: &'static str,
    /// Time \[s\] and value.
    pub values: Vec<(f64, f64)>,
}

/// Time offset of a recording's odometry against its scans.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct OdometryTiming {
    /// Offset added to its stamps \[s\]; negative for a delayed odometry.
    pub delay_s: f64,
    /// Estimate from the scans \[s\]; null where none was made or possible.
    pub estimated_s: Option<f64>,
    /// Standard deviation of the estimate \[s\].
    pub sigma_s: Option<f64>,
    /// Number of pairs of scans used.
    pub pairs: usize,
}

/// A stream of events in order of arrival.
// ANCHOR: source
pub trait Source {
    /// What is known before the first event.
    fn setup(&self) -> &Setup;

    /// The next event, `None` at the end.
    ///
    /// # Errors
    /// An error in the recording, with its place.
    fn next_event(&mut self) -> Result<Option<Event>>;

    /// What was skipped, as counted lines for the user: `3 observations of unknown barcodes`.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }

    /// The true errors of the sensors so far, of a simulated robot that records them.
    fn sensor_truth(&self) -> SensorTruth {
        SensorTruth::default()
    }

    /// Whether the true poses have headings; where only positions are known, theirs are 0.
    fn truth_has_heading(&self) -> bool {
        true
    }

    /// The time offset of the odometry against the scans, where a recording has one.
    fn odometry_timing(&self) -> Option<OdometryTiming> {
        None
    }

    /// Whether true poses are among the events. Without any, a run is sampled at its scans.
    fn has_truth(&self) -> bool {
        true
    }
}
// ANCHOR_END: source

/// A queue that returns events in order of arrival; equal ones first in, first out.
#[derive(Debug, Default)]
pub(super) struct ArrivalQueue {
    heap: BinaryHeap<Queued>,
    count: u64,
}

#[derive(Debug)]
struct Queued {
    event: Event,
    number: u64,
}

impl ArrivalQueue {
    pub(super) fn push(&mut self, event: Event) {
        self.heap.push(Queued { event, number: self.count });
        self.count += 1;
    }

    /// The first event if it arrived before `until` \[s\]; the caller still adds events that arrive
    /// from then on.
    pub(super) fn pop(&mut self, until: f64) -> Option<Event> {
        let first = self.heap.peek()?;
        if first.event.arrival < until { self.heap.pop().map(|queued| queued.event) } else { None }
    }
}

impl Ord for Queued {
    /// Reversed, since the heap gives its greatest element first.
    fn cmp(&self, other: &Self) -> Ordering {
        other.event.order(&self.event).then(other.number.cmp(&self.number))
    }
}

impl PartialOrd for Queued {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Queued {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Queued {}

/// The pose of an odometry that reports poses or velocities; velocities are integrated from the
/// origin.
#[derive(Debug, Clone, Default)]
pub(crate) struct OdometryIntegrator {
    pose: Pose2,
    velocity: Option<(f64, Twist2)>,
}

impl OdometryIntegrator {
    /// The last pose.
    pub(crate) fn last(&self) -> Pose2 {
        self.pose
    }

    /// The pose at the time of a control; `None` for a control that is no motion in the plane.
    pub(crate) fn pose(&mut self, stamp: f64, control: &Control) -> Option<Pose2> {
        match control {
            Control::Odometry(pose) => {
                self.velocity = None;
                self.pose = *pose;
            }
            Control::Velocity(twist) => {
                self.integrate_to(stamp);
                self.velocity = Some((stamp, *twist));
            }
            Control::Acceleration(_) => return None,
        }
        Some(self.pose)
    }

    /// Integrates the last velocity up to a time \[s\].
    pub(crate) fn integrate_to(&mut self, stamp: f64) -> Pose2 {
        if let Some((since, twist)) = &mut self.velocity {
            let step = twist.to_vector() * (stamp - *since).max(0.0);
            self.pose = self.pose * Pose2::exp(&step);
            *since = stamp;
        }
        self.pose
    }
}

/// How well a start pose is known, as standard deviations; the filters start at a pose drawn from it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StartSigma {
    /// Of x and of y \[m\].
    pub position: f64,
    /// Of the heading \[rad\].
    #[serde(with = "loc_core::settings::angle")]
    pub heading: f64,
}

impl StartSigma {
    /// Standard deviations of (x, y, heading) \[m, m, rad\].
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for negative ones.
    pub fn sigmas(&self) -> Result<[f64; 3]> {
        let position = non_negative("start_sigma.position [m]", self.position)?;
        let heading = non_negative("start_sigma.heading [rad]", self.heading)?;
        Ok([position, position, heading])
    }
}
