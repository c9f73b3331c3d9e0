//! A bag of ROS as a recording to replay.
//!
//! [`loc_ros::Recording`] reads the bag; here are the start pose, the choice of scans and the delay
//! of the odometry, which comes from the turns of the scans.

use super::laser_log::{Entry, LaserLog, RecordedScan, ReplayOptions, Scans, belief, start_pose};
use super::{OdometryTiming, Setup, Source};
use crate::Result;
use loc_pf::delay::{DelayEstimate, DelayEstimator, DelaySettings};
use loc_ros::{Moment, Recording, RecordingOptions};
use loc_sensors::event::{Event, Measurement};
use std::collections::VecDeque;
use std::path::Path;
use std::sync::Arc;

/// Entries that are looked through for a true pose, where there is none up to the first scan.
const LOOK_AHEAD: usize = 2000;

/// How much of a bag is used to estimate the delay of its odometry \[s\].
const DELAY_WINDOW: f64 = 600.0;

/// How much later than its stamp the robot was where its odometry says; negative for an odometry
/// that comes late.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum OdometryDelay {
    /// That of [`RecordingOptions::odometry_delay`].
    #[default]
    Known,
    /// As much as the turns of the scans say, where that is significant: the bag is read once more
    /// up to where they say enough. See [`loc_pf::delay`].
    Estimated,
}

/// What is not found in a bag by itself.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RosOptions {
    /// Topics, frames, mounting, noise.
    pub recording: RecordingOptions,
    /// The delay of the odometry.
    pub odometry_delay: OdometryDelay,
}

impl From<RecordingOptions> for RosOptions {
    fn from(recording: RecordingOptions) -> Self {
        RosOptions { recording, ..RosOptions::default() }
    }
}

/// A bag as a stream of events, from the first scan on. What is held in memory does not grow with
/// the bag.
#[derive(Debug)]
pub struct RosRecording {
    setup: Setup,
    recording: Recording,
    timing: OdometryTiming,
    scans: Scans,
    /// Entries read ahead, and events of the entry read last.
    entries: VecDeque<Entry>,
    events: VecDeque<Event>,
    number_of_scans: usize,
    start_is_known: bool,
    notes: Vec<String>,
}

impl RosRecording {
    /// Opens a bag for a replay.
    ///
    /// # Errors
    /// What is wrong with the bag; [`loc_ros::Error::Recording`] for one without scans or odometry,
    /// or with several of them and none chosen, [`crate::Error::Recording`] for an unknown start
    /// pose; [`loc_ros::Error::NoTransform`] where nothing says where the laser sits.
    pub fn open(path: &Path, options: &ReplayOptions, ros: &RosOptions) -> Result<Self> {
        let (mut recording, timing) = open(path, ros)?;
        let (mut entries, mut number_of_scans) = (VecDeque::new(), 0);
        // Everything up to the first scan, and on to the first true pose.
        let mut until_scan = Vec::new();
        let has_truth = recording.has_reference();
        let mut ahead: Vec<Entry> = Vec::new();
        let (mut seen_scan, mut seen_truth) = (false, !has_truth);
        while !(seen_scan && seen_truth) && ahead.len() < LOOK_AHEAD {
            let Some(moment) = recording.next_moment()? else { break };
            if let Some(entry) = entry(moment) {
                let entry = selected(entry, options.scans, &mut number_of_scans);
                seen_scan |= entry.has_scan();
                seen_truth |= entry.truth().is_some();
                if seen_scan { ahead.push(entry) } else { remember(&mut until_scan, entry) }
            }
        }
        if !seen_scan {
            return Err(recording.no_scans().into());
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
            end: start.max(recording.end()),
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
            recording,
            timing,
            scans: options.scans,
            entries,
            events: VecDeque::new(),
            number_of_scans,
            start_is_known,
            notes,
        })
    }

    /// Whether anything said where the robot starts.
    pub fn start_is_known(&self) -> bool {
        self.start_is_known
    }
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
            if let Some(entry) = self.entries.pop_front() {
                self.events.extend(entry.events());
                continue;
            }
            let Some(moment) = self.recording.next_moment()? else { return Ok(None) };
            let select = |entry| selected(entry, self.scans, &mut self.number_of_scans);
            self.entries.extend(entry(moment).map(select));
        }
    }

    fn notes(&self) -> Vec<String> {
        self.recording.notes().into_iter().chain(self.notes.iter().cloned()).collect()
    }

    fn has_truth(&self) -> bool {
        self.recording.has_reference()
    }

    fn odometry_timing(&self) -> Option<OdometryTiming> {
        Some(self.timing)
    }
}

/// The whole bag in memory, for what needs it at once.
///
/// # Errors
/// As [`RosRecording::open`], but for the start pose.
pub fn laser_log(path: &Path, ros: &RosOptions) -> Result<LaserLog> {
    let (mut recording, _) = open(path, ros)?;
    let mut entries = Vec::new();
    while let Some(moment) = recording.next_moment()? {
        entries.extend(entry(moment));
    }
    if !entries.iter().any(Entry::has_scan) {
        return Err(recording.no_scans().into());
    }
    Ok(LaserLog { path: path.to_owned(), entries, notes: recording.notes() })
}

/// Opens a bag; where the delay of its odometry is to be estimated, its start is read once more.
fn open(path: &Path, options: &RosOptions) -> Result<(Recording, OdometryTiming)> {
    let recording = Recording::open(path, &options.recording)?;
    let mut timing = OdometryTiming {
        delay_s: recording.odometry_delay(),
        estimated_s: None,
        sigma_s: None,
        pairs: 0,
    };
    if options.odometry_delay == OdometryDelay::Known {
        return Ok((recording, timing));
    }
    let Some(found) = estimated_delay(recording.restarted(0.0, None)?)? else {
        let note = "delay of the odometry not estimated: too few turns in the scans";
        timing.delay_s = 0.0;
        return Ok((recording.restarted(0.0, Some(note.into()))?, timing));
    };
    let DelayEstimate { delay, sigma, pairs, .. } = found;
    let used = if found.is_significant() { delay } else { 0.0 };
    let by = format!("{delay:+.3} s, sigma {sigma:.3} s, by the turns of {pairs} scans");
    let note = match used.abs() > 0.0 {
        true => format!("odometry moved in time by {by} (--odom-delay 0 for not)"),
        false => format!("odometry left in time: not significant, {by}"),
    };
    let timing =
        OdometryTiming { delay_s: used, estimated_s: Some(delay), sigma_s: Some(sigma), pairs };
    Ok((recording.restarted(used, Some(note))?, timing))
}

/// What the scans of a bag say about the delay of its odometry.
fn estimated_delay(mut recording: Recording) -> Result<Option<DelayEstimate>> {
    let mut estimator = DelayEstimator::new(DelaySettings::default())?;
    let mut start = None;
    while let Some(moment) = recording.next_moment()? {
        let begin = *start.get_or_insert(moment.stamp);
        if estimator.has_enough() || moment.stamp > begin + DELAY_WINDOW {
            break;
        }
        match (moment.measurement, moment.odometry) {
            (Some(Measurement::Scan { scan, mounting }), _) => {
                estimator.scan(moment.stamp, &scan, mounting);
            }
            (None, Some(pose)) => estimator.odometry(moment.stamp, pose),
            _ => {}
        }
    }
    Ok(estimator.estimate())
}

/// A moment as an entry of a log.
fn entry(moment: Moment) -> Option<Entry> {
    let Moment { stamp, odometry, measurement, truth } = moment;
    match (measurement, odometry) {
        (Some(Measurement::Scan { scan, mounting }), Some(odometry)) => {
            Some(Entry::of_scan(stamp, RecordedScan { scan, mounting, odometry, truth }))
        }
        (Some(measurement), _) => Some(Entry::of_measurement(stamp, measurement)),
        (None, Some(odometry)) => Some(Entry::of_odometry(stamp, odometry)),
        (None, None) => truth.map(|pose| Entry::of_truth(stamp, pose)),
    }
}

/// An entry as it is used: the odometry of a scan that is left out stays.
fn selected(mut entry: Entry, scans: Scans, number: &mut usize) -> Entry {
    if entry.has_scan() {
        let used = scans.takes(*number);
        *number += 1;
        if !used {
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
