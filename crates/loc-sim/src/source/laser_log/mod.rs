//! Recordings of a robot with odometry and a laser scanner, whatever file they came from.
//!
//! A reader of a format fills a [`LaserLog`]; [`LaserRecording`] turns it into a stream of events:
//! it picks scans, finds the start pose, puts a reference beside the log, and can cut a piece out
//! so that the robot is suddenly elsewhere.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_sim::source::laser_log::{Entry, LaserLog, LaserRecording, RecordedScan, ReplayOptions, What};
//! use loc_sim::source::{Source, carmen};
//! let text = "FLASER 3 1 2 3 0.1 0 0 5 5 0 10 host 10\nFLASER 3 1 2 3 0.6 0 0 5.5 5 0.1 11 host 11\n";
//! let log = carmen::CarmenLog::parse("demo.log", text.as_bytes()).laser_log()?;
//! let mut recording = LaserRecording::new(log, &ReplayOptions::default())?;
//! // The laser's pose is not the odometry's: it is the reference, and the run starts there.
//! let start = recording.setup().start_belief.pose();
//! assert!(start.distance(Pose2::new(0.1, 0.0, 0.0)) < 1e-12);
//! let mut events = 0;
//! while recording.next_event()?.is_some() {
//!     events += 1;
//! }
//! assert_eq!(events, 6); // odometry, scan and truth, twice
//! # Ok::<(), loc_sim::Error>(())
//! ```

mod kidnap;
mod lines;
mod reference;
mod select;
mod stamps;
mod start;
mod words;

pub use lines::open;
pub use reference::Reference;
pub use select::Scans;
pub use start::Start;

pub(super) use lines::LogLines;
pub(super) use start::start_pose;
pub(super) use words::Words;

use super::{Setup, Source};
use crate::{Error, Result};
use loc_core::{Gaussian, Pose2};
use loc_maps::{LineMap, OccupancyGrid};
use loc_sensors::event::{Control, Event, Measurement, Payload, Truth};
use loc_sensors::laser::LaserScan;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What a log of a robot with a laser holds, in the order of the log.
#[derive(Debug, Clone, PartialEq)]
pub struct LaserLog {
    /// The file.
    pub path: PathBuf,
    /// Its messages.
    pub entries: Vec<Entry>,
    /// What was passed over, as lines for the user.
    pub notes: Vec<String>,
}

/// A message of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Its time \[s\].
    pub stamp: f64,
    /// What it says.
    pub what: What,
}

/// What a message says.
#[derive(Debug, Clone, PartialEq)]
pub enum What {
    /// The robot's pose in its odometry.
    Odometry(Pose2),
    /// A scan.
    Scan(RecordedScan),
    /// The robot's pose in the map.
    Truth(Pose2),
    /// What a sensor other than the laser measured.
    Measured(Measurement),
}

/// A scan of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedScan {
    /// The ranges.
    pub scan: Arc<LaserScan>,
    /// Where the laser sits on the robot (`base_from_laser`).
    pub mounting: Pose2,
    /// The robot's pose in its odometry at that moment.
    pub odometry: Pose2,
    /// Its pose in the map, where the log gives it.
    pub truth: Option<Pose2>,
}

/// What a replay makes of a log.
#[derive(Debug, Clone, Default)]
pub struct ReplayOptions {
    /// The map to localize in.
    pub map: Option<Arc<OccupancyGrid>>,
    /// The walls as lines; those found in the map where left out.
    pub lines: Option<Arc<LineMap>>,
    /// Which scans are used.
    pub scans: Scans,
    /// Where the robot starts.
    pub start: Start,
    /// Standard deviations of the start pose over (x, y, theta) \[m, m, rad\].
    pub start_sigmas: [f64; 3],
    /// When the robot is carried away, after the first scan that is used \[s\].
    pub kidnap: Option<f64>,
    /// Poses in the map to judge by, in place of those of the log.
    pub reference: Option<Reference>,
}

/// A log as a stream of events. It starts at the first scan that is used; what the log holds
/// before it is passed over.
#[derive(Debug)]
pub struct LaserRecording {
    setup: Setup,
    events: std::vec::IntoIter<Event>,
    has_truth: bool,
    start_is_known: bool,
    notes: Vec<String>,
}

impl LaserRecording {
    /// Prepares a log for a replay.
    ///
    /// # Errors
    /// [`Error::Recording`] for a log without scans, a start pose that nobody knows or that lies
    /// outside the map, and a kidnapping that the log has no room for.
    pub fn new(mut log: LaserLog, options: &ReplayOptions) -> Result<Self> {
        stamps::mend(&mut log);
        select::select(&mut log, options.scans)?;
        if let Some(reference) = &options.reference {
            reference::put_beside(&mut log, reference)?;
        }
        let (pose, start_is_known) = start::start_pose(&mut log, options)?;
        select::start_at_first_scan(&mut log);
        let first_stamp = log.entries.first().map_or(0.0, |entry| entry.stamp);
        let kidnapped_at =
            options.kidnap.map(|after| kidnap::kidnap(&mut log, after)).transpose()?;
        let has_truth = log.entries.iter().any(|entry| entry.truth().is_some());
        if !has_truth {
            log.notes.push("no reference to judge by: errors are left out".into());
        }
        let setup = Setup {
            name: name(&log.path),
            start: first_stamp,
            end: log.entries.last().map_or(first_stamp, |entry| entry.stamp),
            start_belief: belief(pose, options.start_sigmas)?,
            rail: None,
            landmarks: Arc::default(),
            map: options.map.clone(),
            lines: options.lines.clone(),
            has_laser: true,
            kidnapped_at,
        };
        let events: Vec<Event> = log.entries.into_iter().flat_map(Entry::events).collect();
        let (events, notes) = (events.into_iter(), log.notes);
        Ok(LaserRecording { setup, events, has_truth, start_is_known, notes })
    }

    /// Whether anything said where the robot starts.
    pub fn start_is_known(&self) -> bool {
        self.start_is_known
    }
}

impl Source for LaserRecording {
    fn setup(&self) -> &Setup {
        &self.setup
    }

    fn next_event(&mut self) -> Result<Option<Event>> {
        Ok(self.events.next())
    }

    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    fn has_truth(&self) -> bool {
        self.has_truth
    }
}

impl Entry {
    /// The robot's pose in its odometry, where the message gives it.
    fn odometry(&self) -> Option<Pose2> {
        match &self.what {
            What::Odometry(pose) => Some(*pose),
            What::Scan(scan) => Some(scan.odometry),
            What::Truth(_) | What::Measured(_) => None,
        }
    }

    /// The robot's pose in the map, where the message gives it.
    pub(super) fn truth(&self) -> Option<Pose2> {
        match &self.what {
            What::Odometry(_) | What::Measured(_) => None,
            What::Scan(scan) => scan.truth,
            What::Truth(pose) => Some(*pose),
        }
    }

    fn is_scan(&self) -> bool {
        matches!(self.what, What::Scan(_))
    }

    pub(super) fn events(self) -> Vec<Event> {
        let (odometry, truth) = (self.odometry(), self.truth());
        let odometry = odometry.map(|pose| Payload::Control(Control::Odometry(pose)));
        let truth = truth.map(|pose| Payload::Truth(Truth { pose, speed: None }));
        let measured = match self.what {
            What::Scan(RecordedScan { scan, mounting, .. }) => {
                Some(Payload::Measurement(Measurement::Scan { scan, mounting }))
            }
            What::Measured(measurement) => Some(Payload::Measurement(measurement)),
            What::Odometry(_) | What::Truth(_) => None,
        };
        let payloads = [odometry, measured, truth].into_iter().flatten();
        payloads.map(|payload| Event::now(self.stamp, payload)).collect()
    }
}

pub(super) fn belief(pose: Pose2, sigmas: [f64; 3]) -> Result<Gaussian<3>> {
    for (what, sigma) in
        ["sigma of the start [m]", "sigma of the start [m]", "sigma [rad]"].into_iter().zip(sigmas)
    {
        loc_core::error::non_negative(what, sigma)?;
    }
    Ok(loc_core::gaussian::pose_belief(pose, sigmas))
}

/// The file's name without `.log` and `.gz`.
fn name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    name.strip_suffix(".log").unwrap_or(name).to_owned()
}

fn unsuitable(log: &LaserLog, expected: impl Into<String>, found: impl Into<String>) -> Error {
    Error::Recording { path: log.path.clone(), expected: expected.into(), found: found.into() }
}
