//! A recording as a CARMEN log.

use super::left_out::LeftOut;
use super::{Converted, each};
use crate::odometry::Driven;
use crate::source::Source;
use crate::{Error, Result};
use loc_core::Pose2;
use loc_sensors::event::{Event, Measurement, Payload};
use loc_sensors::laser::LaserScan;
use std::io::Write;
use std::path::Path;

/// Writes odometry (`ODOM`), scans (`ROBOTLASER1`) and true poses (`TRUEPOS`) of a recording.
///
/// Beams that saw nothing, and those that are no ranges at all, are written as the greatest range,
/// which is how the format says it. `path` is only named in errors.
///
/// # Errors
/// What the source reports, [`loc_core::Error::Io`], and [`Error::Recording`] for a recording with
/// nothing that the format has a line for.
pub fn to_carmen(
    source: &mut dyn Source,
    out: impl Write,
    path: &Path,
    progress: &mut dyn FnMut(f64),
) -> Result<Converted> {
    let mut log =
        Log { out, path, driven: Driven::default(), written: 0, left_out: LeftOut::default() };
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
    driven: Driven,
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
            Payload::Control(control) => match self.driven.pose(stamp, control) {
                Some(pose) => self.line(format_args!("ODOM {} 0 0 0 {end}", words(pose))),
                None => {
                    self.left_out.count("accelerations");
                    Ok(())
                }
            },
            Payload::Measurement(Measurement::Scan { scan, mounting }) => {
                let robot = self.driven.drive_to(stamp);
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
                let robot = self.driven.drive_to(stamp);
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
