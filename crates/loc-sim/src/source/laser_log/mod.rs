//! Recordings of a robot with odometry and a laser scanner, in any file format.
//!
//! A reader of a format fills a [`LaserLog`] with [`Entry`]s: the payloads of events, grouped by
//! message. [`LaserRecording`] prepares them for a replay and yields them as events: it repairs the
//! stamps, selects scans, merges a separate reference, finds the start pose, and can cut out a
//! piece of the log, which simulates a kidnapped robot.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_sim::source::laser_log::{LaserRecording, ReplayOptions};
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

mod reference;

pub use reference::Reference;

use super::{Setup, Source};
use crate::{Error, Result};
use loc_core::{Gaussian, Pose2};
use loc_maps::grid::Occupancy;
use loc_maps::{LineMap, OccupancyGrid};
use loc_sensors::event::{Control, Event, Measurement, Payload, Truth};
use loc_sensors::laser::LaserScan;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The content of a log of a robot with a laser, in the order of the log.
#[derive(Debug, Clone, PartialEq)]
pub struct LaserLog {
    /// The file.
    pub path: PathBuf,
    /// Its messages.
    pub entries: Vec<Entry>,
    /// What was skipped, as lines for the user.
    pub notes: Vec<String>,
}

/// A message of a log: the payloads of the events that it stands for, all of one stamp.
///
/// The pose of the odometry comes first, then the scan or another measurement, then the true pose;
/// each is optional.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Its time \[s\].
    pub stamp: f64,
    /// Its content, in the order of the events.
    pub payloads: Vec<Payload>,
}

/// The parts of a scan in a log.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedScan {
    /// The ranges.
    pub scan: Arc<LaserScan>,
    /// The laser's pose on the robot (`base_from_laser`).
    pub mounting: Pose2,
    /// The robot's pose in its odometry at that time.
    pub odometry: Pose2,
    /// Its pose in the map, where the log has it.
    pub truth: Option<Pose2>,
}

impl Entry {
    /// The robot's pose in its odometry.
    pub fn of_odometry(stamp: f64, pose: Pose2) -> Self {
        Entry { stamp, payloads: vec![odometry_payload(pose)] }
    }

    /// A scan with the poses of its time.
    pub fn of_scan(stamp: f64, recorded: RecordedScan) -> Self {
        let RecordedScan { scan, mounting, odometry, truth } = recorded;
        let scan = Payload::Measurement(Measurement::Scan { scan, mounting });
        let mut payloads = vec![odometry_payload(odometry), scan];
        payloads.extend(truth.map(truth_payload));
        Entry { stamp, payloads }
    }

    /// The robot's pose in the map.
    pub fn of_truth(stamp: f64, pose: Pose2) -> Self {
        Entry { stamp, payloads: vec![truth_payload(pose)] }
    }

    /// A measurement of a sensor other than the laser.
    pub fn of_measurement(stamp: f64, measurement: Measurement) -> Self {
        Entry { stamp, payloads: vec![Payload::Measurement(measurement)] }
    }

    /// The robot's pose in its odometry, where the message has it.
    pub fn odometry(&self) -> Option<Pose2> {
        self.payloads.iter().find_map(|payload| match payload {
            Payload::Control(Control::Odometry(pose)) => Some(*pose),
            _ => None,
        })
    }

    /// The scan with the laser's pose on the robot, where the message has one.
    pub fn scan(&self) -> Option<(&LaserScan, Pose2)> {
        self.payloads.iter().find_map(|payload| match payload {
            Payload::Measurement(Measurement::Scan { scan, mounting }) => {
                Some((scan.as_ref(), *mounting))
            }
            _ => None,
        })
    }

    /// The robot's pose in the map, where the message has it.
    pub fn truth(&self) -> Option<Pose2> {
        self.payloads.iter().find_map(|payload| match payload {
            Payload::Truth(truth) => Some(truth.pose),
            _ => None,
        })
    }

    pub(crate) fn has_scan(&self) -> bool {
        self.scan().is_some()
    }

    /// Reduces the message of a scan to its odometry.
    pub(super) fn drop_scan(&mut self) {
        self.payloads.retain(|payload| matches!(payload, Payload::Control(_)));
    }

    pub(super) fn events(self) -> impl Iterator<Item = Event> {
        self.payloads.into_iter().map(move |payload| Event::now(self.stamp, payload))
    }
}

fn odometry_payload(pose: Pose2) -> Payload {
    Payload::Control(Control::Odometry(pose))
}

fn truth_payload(pose: Pose2) -> Payload {
    Payload::Truth(Truth { pose, speed: None })
}

/// Options of a replay.
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
    /// When the robot is kidnapped, after the first scan that is used \[s\].
    pub kidnap: Option<f64>,
    /// Reference poses in the map, in place of those of the log.
    pub reference: Option<Reference>,
}

/// Which scans of a log to use, counted from 0 over all that it holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Scans {
    /// Every scan.
    #[default]
    All,
    /// 1, 3, 5, ..
    Odd,
    /// 0, 2, 4, ..
    Even,
}

impl Scans {
    /// Whether scan `index` is used.
    pub fn takes(self, index: usize) -> bool {
        match self {
            Scans::All => true,
            Scans::Odd => index % 2 == 1,
            Scans::Even => index.is_multiple_of(2),
        }
    }
}

/// Where the robot starts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Start {
    /// At the reference.
    #[default]
    Reference,
    /// At this pose in the map, with the first scan that is used.
    At(Pose2),
    /// Unknown for methods that search the whole map; others start at the reference or, without
    /// one, at the pose of the odometry.
    Anywhere,
}

/// A log as a stream of events. It starts at the first scan that is used; earlier messages are
/// skipped.
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
    /// [`Error::Recording`] for a log without scans, an unknown start pose or one
    /// outside the map, and a kidnapping that does not fit into the log.
    pub fn new(mut log: LaserLog, options: &ReplayOptions) -> Result<Self> {
        repair_stamps(&mut log);
        select_scans(&mut log, options.scans)?;
        if let Some(reference) = &options.reference {
            reference::merge(&mut log, reference)?;
        }
        let (pose, start_is_known) = start_pose(&mut log, options)?;
        start_at_first_scan(&mut log);
        let first_stamp = log.entries.first().map_or(0.0, |entry| entry.stamp);
        let kidnapped_at = options.kidnap.map(|after| kidnap(&mut log, after)).transpose()?;
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

    /// Whether the start pose is known.
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

/// Makes the stamps of a log ascending. Where most scans do not have a later stamp than the scan
/// before, all stamps are replaced by the number of the scan, 1 s apart; a single stamp that goes
/// backwards is set to that of the message before.
fn repair_stamps(log: &mut LaserLog) {
    let stamps: Vec<f64> = log.entries.iter().filter(|e| e.has_scan()).map(|e| e.stamp).collect();
    let stuck = stamps.windows(2).filter(|pair| pair[1] <= pair[0]).count();
    if 2 * stuck > stamps.len().saturating_sub(1) {
        number_scans(&mut log.entries);
        log.notes.push("its stamps do not ascend: scans are taken as 1 s apart".into());
        return;
    }
    let (mut last, mut backwards) = (f64::NEG_INFINITY, 0);
    for entry in &mut log.entries {
        if entry.stamp < last {
            entry.stamp = last;
            backwards += 1;
        }
        last = entry.stamp;
    }
    if backwards > 0 {
        log.notes.push(format!("{backwards} messages with a stamp before the last one, set to it"));
    }
}

/// Sets the stamp of every message to the number of the scan that it contains or follows.
fn number_scans(entries: &mut [Entry]) {
    let mut scans = 0_u32;
    for entry in entries {
        scans += u32::from(entry.has_scan());
        entry.stamp = f64::from(scans.saturating_sub(1));
    }
}

/// Removes the scans that are not used, with their reference; their odometry stays.
fn select_scans(log: &mut LaserLog, scans: Scans) -> Result<()> {
    let (mut index, mut taken) = (0, 0);
    for entry in &mut log.entries {
        if !entry.has_scan() {
            continue;
        }
        if scans.takes(index) {
            taken += 1;
        } else {
            entry.drop_scan();
        }
        index += 1;
    }
    match taken {
        0 => Err(unsuitable(log, "laser scans to use", format!("none among its {index}"))),
        _ => Ok(()),
    }
}

/// Removes the messages before the first scan.
fn start_at_first_scan(log: &mut LaserLog) {
    let first = log.entries.iter().position(Entry::has_scan).unwrap_or(0);
    log.entries.drain(..first);
}

/// The pose at the first scan, and whether it is known.
pub(super) fn start_pose(log: &mut LaserLog, options: &ReplayOptions) -> Result<(Pose2, bool)> {
    let first = log.entries.iter().position(Entry::has_scan).unwrap_or(0);
    let odometry = log.entries.get(first).and_then(Entry::odometry).unwrap_or_default();
    let (pose, known) = match (options.start, by_reference(&log.entries, first)) {
        (Start::At(pose), _) if !pose.is_finite() => {
            return Err(unsuitable(log, "a finite start pose", pose.to_string()));
        }
        (Start::At(pose), _) => (pose, true),
        (_, Some(map_from_odom)) => (map_from_odom * odometry, true),
        (Start::Anywhere, None) => (odometry, false),
        (Start::Reference, None) => {
            let expected = "a reference to start from, a start pose (--initial-pose x,y,yaw) or a \
                            search for it (--global)";
            return Err(unsuitable(log, expected, "none of them"));
        }
    };
    if let Some(map) = options.map.as_deref().filter(|_| known) {
        check_place(log, pose, map)?;
    }
    Ok((pose, known))
}

/// The pose of the odometry's frame in the map, by the last true pose up to the first scan, or
/// else the first one after it.
fn by_reference(entries: &[Entry], first: usize) -> Option<Pose2> {
    let is_true = |entry: &Entry| entry.truth().is_some();
    let until = entries.get(..=first).unwrap_or_default();
    let place = until.iter().rposition(is_true).or_else(|| entries.iter().position(is_true))?;
    let before = entries[..=place].iter().rev().find_map(Entry::odometry);
    let odometry = before.or_else(|| entries[place..].iter().find_map(Entry::odometry))?;
    Some(entries[place].truth()? * odometry.inverse())
}

fn check_place(log: &mut LaserLog, pose: Pose2, map: &OccupancyGrid) -> Result<()> {
    if map.frame().cell_at(&pose.position()).is_none() {
        return Err(unsuitable(log, "a start pose inside the map", pose.to_string()));
    }
    let kind = match map.occupancy_at(&pose.position()) {
        Occupancy::Free => return Ok(()),
        Occupancy::Occupied => "an occupied",
        Occupancy::Unknown => "an unknown",
    };
    log.notes.push(format!("the start pose {pose} lies in {kind} cell of the map"));
    Ok(())
}

/// Smallest distance of a kidnapping \[m\]: beyond what position tracking can follow.
const KIDNAP_DISTANCE: f64 = 5.0;

/// Cuts a piece out of a log, from the first scan at `after` \[s\] on to the first one at least
/// [`KIDNAP_DISTANCE`] away. That one takes the stamp and the odometry of the first that was cut out, and
/// later messages are shifted likewise: a filter gets continuous time and odometry, while the robot
/// is elsewhere. Returns the stamp of the cut.
fn kidnap(log: &mut LaserLog, after: f64) -> Result<f64> {
    loc_core::error::non_negative("kidnapping [s]", after)?;
    let start = log.entries.first().map_or(0.0, |entry| entry.stamp);
    let is_late = |entry: &Entry| entry.has_scan() && entry.stamp >= start + after;
    let Some(cut) = log.entries.iter().position(is_late).filter(|cut| *cut > 0) else {
        let end = log.entries.last().map_or(0.0, |entry| entry.stamp - start);
        let expected = format!("a time of kidnapping above 0 s and up to {end:.3} s, its end");
        return Err(unsuitable(log, expected, format!("{after} s")));
    };
    let places = places(&log.entries);
    let far = |(_, (entry, place)): &(usize, (&Entry, &Pose2))| {
        entry.has_scan() && place.distance(places[cut]) >= KIDNAP_DISTANCE
    };
    let rest = log.entries.iter().zip(&places).enumerate().skip(cut);
    let Some((resume, _)) = rest.into_iter().find(far) else {
        let expected =
            format!("a scan at least {KIDNAP_DISTANCE} m from where the robot is at {after} s");
        return Err(unsuitable(log, expected, "none in the rest of the recording"));
    };
    cut_out(&mut log.entries, cut, resume);
    Ok(log.entries[cut].stamp)
}

/// The robot's position at each entry: by the last true pose, or by odometry where there is none.
fn places(entries: &[Entry]) -> Vec<Pose2> {
    let has_truth = entries.iter().any(|entry| entry.truth().is_some());
    let mut last = Pose2::IDENTITY;
    let place = |entry: &Entry| {
        let given = if has_truth { entry.truth() } else { entry.odometry() };
        last = given.unwrap_or(last);
        last
    };
    entries.iter().map(place).collect()
}

/// Removes the entries from `cut` up to `resume` and joins the two ends.
fn cut_out(entries: &mut Vec<Entry>, cut: usize, resume: usize) {
    let gap = entries[resume].stamp - entries[cut].stamp;
    let odometry = |entry: &Entry| entry.odometry().unwrap_or_default();
    let shift = odometry(&entries[cut]) * odometry(&entries[resume]).inverse();
    entries.drain(cut..resume);
    for entry in &mut entries[cut..] {
        entry.stamp -= gap;
        for payload in &mut entry.payloads {
            if let Payload::Control(Control::Odometry(pose)) = payload {
                *pose = shift * *pose;
            }
        }
    }
}

/// The initial pose distribution.
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
