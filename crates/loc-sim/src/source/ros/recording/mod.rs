//! A bag as a recording to replay: scans with the odometry of their moment and the laser's place
//! on the robot, as a stream.
//!
//! The bag is read twice. The first time counts its topics, finds the one with the scans and the
//! one with the odometry by their types, and collects the fixed transforms (`/tf_static` may come
//! late). The second time makes the events.
//!
//! Messages come in order of arrival, but belong to the time of their stamps: a scan waits until
//! the odometry has passed its stamp, and gets the pose that lies between the two around it.

mod beside;
mod counts;
mod delay;
mod join;
mod names;
mod noise;
mod options;
mod order;
mod preview;
mod roles;
mod scan;
mod take;

pub use options::{OdometryDelay, RosNames, RosOptions};

use self::delay::MeasuredDelay;
use self::join::Join;
use self::preview::Preview;
use self::roles::Roles;
use crate::source::laser_log::{Entry, LaserLog, ReplayOptions, Scans, belief, start_pose};
use crate::source::{OdometryTiming, Setup, Source};
use crate::{Error, Result};
use loc_sensors::event::Event;
use std::collections::VecDeque;
use std::path::Path;
use std::sync::Arc;

/// Entries that are looked through for a true pose, where there is none up to the first scan.
const LOOK_AHEAD: usize = 2000;

/// A bag as a stream of events, from the first scan on. What is held in memory does not grow with
/// the bag.
#[derive(Debug)]
pub struct RosRecording {
    setup: Setup,
    join: Join,
    scans: Scans,
    /// Entries read ahead, and events of the entry read last.
    entries: VecDeque<Entry>,
    events: VecDeque<Event>,
    number_of_scans: usize,
    has_truth: bool,
    start_is_known: bool,
    notes: Vec<String>,
}

impl RosRecording {
    /// Opens a bag for a replay.
    ///
    /// # Errors
    /// What is wrong with the bag; [`Error::Recording`] for one without scans or odometry, or with
    /// several of them and none chosen, and for a start pose that nobody knows;
    /// [`Error::NoTransform`] where nothing says where the laser sits.
    pub fn open(path: &Path, options: &ReplayOptions, ros: &RosOptions) -> Result<Self> {
        let mut join = open_join(path, ros)?;
        let (mut entries, mut number_of_scans) = (VecDeque::new(), 0);
        // Everything up to the first scan, and on to the first true pose.
        let mut until_scan = Vec::new();
        let has_truth = join.has_reference();
        let mut ahead: Vec<Entry> = Vec::new();
        let (mut seen_scan, mut seen_truth) = (false, !has_truth);
        while !(seen_scan && seen_truth) && ahead.len() < LOOK_AHEAD {
            let Some(entry) = join.next_entry()? else { break };
            let entry = selected(entry, options.scans, &mut number_of_scans);
            seen_scan |= entry.has_scan();
            seen_truth |= entry.truth().is_some();
            if seen_scan { ahead.push(entry) } else { remember(&mut until_scan, entry) }
        }
        if !seen_scan {
            return Err(join.no_scans());
        }
        let first = until_scan.len();
        let mut log = LaserLog { path: path.to_owned(), entries: until_scan, notes: Vec::new() };
        log.entries.append(&mut ahead);
        let (pose, start_is_known) = start_pose(&mut log, options)?;
        entries.extend(log.entries.drain(first..));
        let start = entries.front().map_or(0.0, |entry| entry.stamp);
        let mut notes = std::mem::take(&mut log.notes);
        if !has_truth {
            notes.push("no reference to judge by: errors are left out".into());
        }
        let setup = Setup {
            name: name(path),
            start,
            end: start.max(join.end()),
            start_belief: belief(pose, options.start_sigmas)?,
            rail: None,
            has_laser: true,
            landmarks: Arc::default(),
            map: options.map.clone(),
            lines: options.lines.clone(),
            kidnapped_at: None,
        };
        Ok(RosRecording {
            setup,
            join,
            scans: options.scans,
            entries,
            events: VecDeque::new(),
            number_of_scans,
            has_truth,
            start_is_known,
            notes,
        })
    }

    /// Whether anything said where the robot starts.
    pub fn start_is_known(&self) -> bool {
        self.start_is_known
    }
}

/// The whole bag in memory, for what needs it at once.
///
/// # Errors
/// As [`RosRecording::open`], but for the start pose.
pub fn laser_log(path: &Path, ros: &RosOptions) -> Result<LaserLog> {
    let mut join = open_join(path, ros)?;
    let mut entries = Vec::new();
    while let Some(entry) = join.next_entry()? {
        entries.push(entry);
    }
    if !entries.iter().any(Entry::has_scan) {
        return Err(join.no_scans());
    }
    Ok(LaserLog { path: path.to_owned(), entries, notes: join.notes() })
}

fn open_join(path: &Path, options: &RosOptions) -> Result<Join> {
    let preview = Preview::of(path)?;
    let roles = Roles::choose(path, &preview, options)?;
    let open = |delay: MeasuredDelay| {
        Join::new(super::open(path)?, preview.clone(), roles.clone(), options, delay)
    };
    let delay = match options.odometry_delay {
        OdometryDelay::Known(used) => MeasuredDelay::known(used),
        OdometryDelay::Estimated => MeasuredDelay::of(open(MeasuredDelay::default())?)?,
    };
    open(delay)
}

/// An entry as it is used: the odometry of a scan that is left out stays.
fn selected(mut entry: Entry, scans: Scans, number: &mut usize) -> Entry {
    if entry.has_scan() {
        let taken = scans.takes(*number);
        *number += 1;
        if !taken {
            entry.drop_scan();
        }
    }
    entry
}

/// Keeps the last odometry and the last true pose only: a robot may stand for hours before.
fn remember(entries: &mut Vec<Entry>, entry: Entry) {
    entries.push(entry);
    if entries.len() > LOOK_AHEAD {
        let truth = entries.iter().rposition(|entry| entry.truth().is_some());
        let from = truth.unwrap_or(entries.len()).min(entries.len() - 1).saturating_sub(1);
        entries.drain(..from.max(1));
    }
}

/// The name of the file or folder, without its ending.
fn name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let ending = [".bag", ".mcap", ".db3"].into_iter().find_map(|e| name.strip_suffix(e));
    ending.unwrap_or(&name).to_owned()
}

fn unsuitable(path: &Path, expected: impl Into<String>, found: impl Into<String>) -> Error {
    Error::Recording { path: path.to_owned(), expected: expected.into(), found: found.into() }
}

impl Source for RosRecording {
    fn setup(&self) -> &Setup {
        &self.setup
    }

    fn next_event(&mut self) -> Result<Option<Event>> {
        loop {
            if let Some(event) = self.events.pop_front() {
                return Ok(Some(event));
            }
            let entry = match self.entries.pop_front() {
                Some(entry) => entry,
                None => match self.join.next_entry()? {
                    Some(entry) => selected(entry, self.scans, &mut self.number_of_scans),
                    None => return Ok(None),
                },
            };
            self.events.extend(entry.events());
        }
    }

    fn notes(&self) -> Vec<String> {
        self.join.notes().into_iter().chain(self.notes.iter().cloned()).collect()
    }

    fn has_truth(&self) -> bool {
        self.has_truth
    }

    fn odometry_timing(&self) -> Option<OdometryTiming> {
        Some(self.join.delay.timing())
    }
}
