//! The logs of Wean Hall: a robot of Carnegie Mellon University in its corridors.
//!
//! A log holds two kinds of lines, in centimetres and radians: `O x y theta ts`, the pose of the
//! odometry, and `L x y theta xl yl thetal r1 .. r180 ts`, a scan of half a turn from the right to
//! the left with the poses of the robot and of the laser in the odometry's frame. The laser sits
//! about 25 cm ahead of the robot's centre. A log may be gzipped.
//!
//! ```
//! use loc_sim::source::wean::WeanLog;
//! let ranges = vec!["150"; 179].join(" ");
//! let text = format!("O 100 0 0 0.1\nL 100 0 0 125 0 0 {ranges} 8183 0.2\n");
//! let log = WeanLog::parse("demo.log", std::io::Cursor::new(text)).laser_log()?;
//! let Some((scan, mounting)) = log.entries[1].scan() else { panic!("a scan") };
//! assert_eq!((log.entries[1].odometry().map(|pose| pose.x), mounting.x), (Some(1.0), 0.25));
//! assert_eq!((scan.ranges[0], scan.ranges[179]), (1.5, f64::INFINITY));
//! # Ok::<(), loc_sim::Error>(())
//! ```

use super::laser_log::{Entry, LaserLog, RecordedScan};
use super::text::{self, LogLines, Words};
use crate::Result;
use loc_core::Pose2;
use loc_sensors::laser::LaserScan;
use std::f64::consts::{FRAC_PI_2, PI};
use std::io::BufRead;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Beams of a scan.
const BEAMS: usize = 180;

/// The scanner reports 81.83 to 81.91 m where nothing returns.
const MAX_RANGE: f64 = 81.8;

/// Metres in the unit of the log.
const CENTIMETRE: f64 = 0.01;

/// A log of Wean Hall.
#[derive(Debug)]
pub struct WeanLog {
    lines: LogLines,
}

impl WeanLog {
    /// Opens a log, gzipped or not.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`] where the file cannot be opened.
    pub fn open(file: &Path) -> Result<Self> {
        Ok(WeanLog { lines: LogLines::new(file, text::open(file)?) })
    }

    /// A log from anything that can be read; `file` is only named in errors.
    pub fn parse(file: impl Into<PathBuf>, lines: impl BufRead + 'static) -> Self {
        WeanLog { lines: LogLines::new(file, lines) }
    }

    /// The whole log, to be replayed.
    ///
    /// # Errors
    /// An error in the log, with its place.
    pub fn laser_log(mut self) -> Result<LaserLog> {
        let mut entries = Vec::new();
        while self.lines.advance()? {
            let mut words = self.lines.words();
            let Ok(kind) = words.word("message") else { continue };
            entries.push(match kind {
                "O" => {
                    let odometry = pose(&mut words, "pose")?;
                    Entry::of_odometry(words.number("ts")?, odometry)
                }
                "L" => scan(&mut words)?,
                comment if comment.starts_with('#') => continue,
                other => return Err(words.error("message", "O or L", &format!("`{other}`"))),
            });
            words.end()?;
        }
        Ok(LaserLog { path: self.lines.file().to_owned(), entries, notes: Vec::new() })
    }
}

fn pose(words: &mut Words<'_>, field: &str) -> Result<Pose2> {
    let pose = words.pose(field)?;
    Ok(Pose2::new(CENTIMETRE * pose.x, CENTIMETRE * pose.y, pose.theta))
}

fn scan(words: &mut Words<'_>) -> Result<Entry> {
    let odometry = pose(words, "pose")?;
    let laser = pose(words, "laser pose")?;
    let mut ranges = words.numbers("range", BEAMS)?;
    for range in &mut ranges {
        *range *= CENTIMETRE;
        if *range >= MAX_RANGE {
            *range = f64::INFINITY;
        }
    }
    let angle_increment = PI / BEAMS as f64;
    let scan = LaserScan {
        angle_min: -FRAC_PI_2,
        angle_max: -FRAC_PI_2 + angle_increment * (BEAMS - 1) as f64,
        angle_increment,
        time_increment: 0.0,
        scan_time: 0.0,
        range_min: 0.0,
        range_max: MAX_RANGE,
        ranges,
        intensities: Vec::new(),
    };
    scan.check().map_err(|error| words.error("scan", "a scan", &error.to_string()))?;
    let stamp = words.number("ts")?;
    let mounting = odometry.between(laser);
    let scan = RecordedScan { scan: Arc::new(scan), mounting, odometry, truth: None };
    Ok(Entry::of_scan(stamp, scan))
}
