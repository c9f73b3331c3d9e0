//! Conversion of recordings between formats, as far as the target can represent their content.
//!
//! | to | from | holds |
//! |---|---|---|
//! | [`to_tum`] | any recording | one track: the reference, or else the odometry |
//! | [`to_carmen`] | any recording | odometry, scans of lasers, true poses |
//! | [`to_mcap`] | any recording | odometry, scans, true poses, as messages of ROS 2 |
//! | [`loc_ros::transcribe`] | a bag | its own messages under their own topics, as an MCAP file of ROS 2 |
//!
//! A conversion reads the recording as a stream, and reports in [`Converted`] what it wrote and
//! what it left out.
//!
//! ```
//! use loc_sim::convert::to_tum;
//! use loc_sim::source::carmen::CarmenLog;
//! use loc_sim::source::laser_log::{LaserRecording, ReplayOptions, Start};
//! let text = "FLASER 3 1 2 3 0.1 0 0 5 5 0 10 host 10\nFLASER 3 1 2 3 0.6 0 0 5.5 5 0.1 11 host 11\n";
//! let log = CarmenLog::parse("demo.log", text.as_bytes()).laser_log()?;
//! let options = ReplayOptions { start: Start::Anywhere, ..ReplayOptions::default() };
//! let mut recording = LaserRecording::new(log, &options)?;
//! let (track, converted) = to_tum(&mut recording, None, &mut |_| {})?;
//! assert_eq!(track.len(), 2);
//! assert_eq!(converted.written, 2);
//! # Ok::<(), loc_sim::Error>(())
//! ```

mod mcap;

pub use mcap::to_mcap;

use crate::source::OdometryIntegrator;
use crate::source::Source;
use crate::{Error, Result};
use loc_core::{Pose2, Trajectory};
use loc_sensors::event::{Event, Measurement, Payload};
use loc_sensors::laser::LaserScan;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

/// The result of a conversion.
#[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize)]
pub struct Converted {
    /// Number of messages, lines or poses written.
    pub written: u64,
    /// What the target cannot represent, as counted lines for the user.
    pub left_out: Vec<String>,
}

impl From<loc_ros::Transcribed> for Converted {
    fn from(transcribed: loc_ros::Transcribed) -> Self {
        Converted { written: transcribed.written, left_out: transcribed.left_out }
    }
}

/// Passes every event of a recording to `take`, and the share of its time to `progress`.
fn each(
    source: &mut dyn Source,
    progress: &mut dyn FnMut(f64),
    mut take: impl FnMut(&Event) -> Result<()>,
) -> Result<()> {
    let (start, end) = (source.setup().start, source.setup().end);
    while let Some(event) = source.next_event()? {
        take(&event)?;
        if end > start {
            progress(((event.stamp - start) / (end - start)).clamp(0.0, 1.0));
        }
    }
    Ok(())
}

/// Writes odometry (`ODOM`), scans (`ROBOTLASER1`) and true poses (`TRUEPOS`) of a recording.
///
/// Beams without a return, and invalid ranges, are written as the maximum range, as the format
/// demands. `path` is only named in errors.
///
/// # Errors
/// What the source reports, [`loc_core::Error::Io`], and [`Error::Recording`] for a recording with
/// without anything that the format can represent.
pub fn to_carmen(
    source: &mut dyn Source,
    out: impl Write,
    path: &Path,
    progress: &mut dyn FnMut(f64),
) -> Result<Converted> {
    let mut log = Log {
        out,
        path,
        odometry: OdometryIntegrator::default(),
        written: 0,
        left_out: LeftOut::default(),
    };
    log.line(format_args!("# CARMEN log file, from {}", source.setup().name))?;
    log.written = 0;
    each(source, progress, |event| log.take(event))?;
    log.out.flush().map_err(loc_core::Error::io(path))?;
    if log.written == 0 {
        return Err(Error::Recording {
            path: source.setup().name.clone().into(),
            expected: "odometry, scans or true poses".into(),
            found: "none".into(),
        });
    }
    Ok(Converted { written: log.written, left_out: log.left_out.with_notes(source) })
}

struct Log<'a, W> {
    out: W,
    path: &'a Path,
    odometry: OdometryIntegrator,
    written: u64,
    left_out: LeftOut,
}

impl<W: Write> Log<'_, W> {
    fn line(&mut self, text: std::fmt::Arguments<'_>) -> Result<()> {
        self.written += 1;
        Ok(writeln!(self.out, "{text}").map_err(loc_core::Error::io(self.path))?)
    }

    fn take(&mut self, event: &Event) -> Result<()> {
        let stamp = event.stamp;
        // The last two words are the host, and when the line was logged, counted from the start.
        let end = format!("{stamp} loc-sim {stamp}");
        match &event.payload {
            Payload::Control(control) => match self.odometry.pose(stamp, control) {
                Some(pose) => self.line(format_args!("ODOM {} 0 0 0 {end}", words(pose))),
                None => {
                    self.left_out.count("accelerations");
                    Ok(())
                }
            },
            Payload::Measurement(Measurement::Scan { scan, mounting }) => {
                let robot = self.odometry.integrate_to(stamp);
                let (head, ranges) = self.scan(scan);
                let (laser, robot) = (words(robot * *mounting), words(robot));
                self.line(format_args!(
                    "ROBOTLASER1 {head} {ranges} 0 {laser} {robot} 0 0 0 0 0 {end}"
                ))
            }
            Payload::Measurement(_) => {
                self.left_out.count("measurements that are no scans");
                Ok(())
            }
            Payload::Truth(truth) => {
                let robot = self.odometry.integrate_to(stamp);
                self.line(format_args!("TRUEPOS {} {} {end}", words(truth.pose), words(robot)))
            }
        }
    }

    /// The geometry of a scan, and its ranges with their number in front.
    fn scan(&mut self, scan: &LaserScan) -> (String, String) {
        let (beams, step) = (scan.ranges.len(), scan.angle_increment);
        let view = step * beams.saturating_sub(1) as f64;
        let head = format!("0 {} {view} {step} {} 0 0", scan.angle_min, scan.range_max);
        let mut ranges = beams.to_string();
        for range in &scan.ranges {
            if range.is_nan() {
                self.left_out.count("beams without a range, written as the greatest one");
            }
            let range = if range.is_finite() { *range } else { scan.range_max };
            ranges.push_str(&format!(" {range}"));
        }
        (head, ranges)
    }
}

fn words(pose: Pose2) -> String {
    format!("{} {} {}", pose.x, pose.y, pose.theta)
}

/// A track of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Track {
    /// The true poses, in the map.
    Reference,
    /// The robot's odometry, in its own frame.
    Odometry,
}

/// Writes a track of a recording; the reference where there is one, unless another is given.
///
/// Velocities are integrated from (0, 0, 0). Of several poses of one time the first is taken.
///
/// # Errors
/// [`Error::Recording`] for a recording without such a track, and what the source reports.
pub fn to_tum(
    source: &mut dyn Source,
    track: Option<Track>,
    progress: &mut dyn FnMut(f64),
) -> Result<(Trajectory, Converted)> {
    let preferred = if source.has_truth() { Track::Reference } else { Track::Odometry };
    let track = track.unwrap_or(preferred);
    let (mut poses, mut left_out) = (Trajectory::new(), LeftOut::default());
    let mut odometry = OdometryIntegrator::default();
    each(source, progress, |event| {
        let pose = match (&event.payload, track) {
            (Payload::Truth(truth), Track::Reference) => truth.pose,
            (Payload::Control(control), Track::Odometry) => {
                match odometry.pose(event.stamp, control) {
                    Some(pose) => pose,
                    None => return Ok(()),
                }
            }
            _ => return Ok(()),
        };
        match poses.last() {
            Some(last) if last.stamp >= event.stamp => {
                left_out.count("poses that are not later than the one before");
                Ok(())
            }
            _ => Ok(poses.push(event.stamp, pose)?),
        }
    })?;
    if poses.is_empty() {
        return Err(Error::Recording {
            path: source.setup().name.clone().into(),
            expected: match track {
                Track::Reference => "true poses".into(),
                Track::Odometry => "odometry".into(),
            },
            found: "none".into(),
        });
    }
    let mut left_out = left_out.with_notes(source);
    if track == Track::Reference && !source.truth_has_heading() {
        left_out.push("the reference has no headings: they are written as 0".into());
    }
    let written = poses.len() as u64;
    Ok((poses, Converted { written, left_out }))
}

/// Counts of what the target cannot represent, by kind.
#[derive(Debug, Default)]
struct LeftOut(BTreeMap<String, u64>);

impl LeftOut {
    fn count(&mut self, what: impl Into<String>) {
        *self.0.entry(what.into()).or_insert(0) += 1;
    }

    /// Lines for the user.
    fn lines(self) -> Vec<String> {
        self.0.into_iter().map(|(what, count)| format!("{count} {what}")).collect()
    }

    /// The same, with the notes of the source.
    fn with_notes(self, source: &dyn Source) -> Vec<String> {
        let mut lines = self.lines();
        lines.extend(source.notes());
        lines
    }
}
