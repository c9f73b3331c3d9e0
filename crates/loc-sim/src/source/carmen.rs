//! CARMEN logs: one message a line, of odometry and laser scans.
//!
//! `ODOM`, `FLASER`, `ROBOTLASER1`, `TRUEPOS` and the `PARAM`s of the front laser are read;
//! everything else is counted and skipped. A log may be gzipped. Lengths are metres, angles
//! radians, stamps those of the robot (`ipc_timestamp`).
//!
//! ```
//! use loc_sim::source::carmen::{CarmenLog, Message};
//! let log = "PARAM robot_frontlaser_offset 0.2 nohost 0\n\
//!            ODOM 1.0 2.0 0.5 0.1 0 0 7.5 nohost 7.5\n\
//!            FLASER 3 1.0 2.0 90.0 1.2 2.0 0.5 1.0 2.0 0.5 7.6 nohost 7.6\n";
//! let messages: Vec<Message> = CarmenLog::parse("demo.log", log.as_bytes()).collect::<Result<_, _>>()?;
//! let Message::Laser(laser) = &messages[1] else { panic!("a scan") };
//! assert_eq!((laser.stamp, laser.scan.ranges[1], laser.scan.ranges[2]), (7.6, 2.0, f64::INFINITY));
//! # Ok::<(), loc_sim::Error>(())
//! ```

use super::laser_log::{Entry, LaserLog, RecordedScan};
use super::text::{self, LogLines, Words};
use crate::Result;
use loc_core::{Pose2, Stamped, angle};
use loc_sensors::laser::LaserScan;
use std::f64::consts::PI;
use std::io::BufRead;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A message of a CARMEN log.
#[derive(Debug, Clone, PartialEq)]
pub enum Message {
    /// The pose of the robot in its odometry.
    Odometry(Stamped<Pose2>),
    /// A scan of the front laser.
    Laser(CarmenLaser),
    /// The true pose of a simulated robot.
    Truth(Stamped<Pose2>),
}

/// A CARMEN log, read message by message.
#[derive(Debug)]
pub struct CarmenLog {
    lines: LogLines,
    parameters: LaserParameters,
    skipped: usize,
}

impl CarmenLog {
    /// Opens a log; gzipped ones are unpacked as they are read.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`] where the file cannot be opened.
    pub fn open(file: impl AsRef<Path>) -> Result<Self> {
        let file = file.as_ref();
        Ok(CarmenLog::parse(file, text::open(file)?))
    }

    /// A log from anything that can be read; `file` is only named in errors.
    pub fn parse(file: impl Into<PathBuf>, lines: impl BufRead + 'static) -> Self {
        let lines = LogLines::new(file, lines);
        CarmenLog { lines, parameters: LaserParameters::default(), skipped: 0 }
    }

    /// Number of messages of other kinds skipped so far.
    pub fn skipped(&self) -> usize {
        self.skipped
    }

    /// The front laser's pose on the robot, if a `PARAM` read so far has it.
    pub fn laser_offset(&self) -> Option<Pose2> {
        self.parameters.offset.map(|ahead| Pose2::new(ahead, 0.0, 0.0))
    }

    fn file(&self) -> &Path {
        self.lines.file()
    }

    /// The scans of the whole log.
    ///
    /// # Errors
    /// An error in the log, with its place.
    pub fn lasers(self) -> Result<Vec<CarmenLaser>> {
        let scans = self.filter_map(|message| match message {
            Ok(Message::Laser(laser)) => Some(Ok(laser)),
            Ok(_) => None,
            Err(error) => Some(Err(error)),
        });
        scans.collect()
    }

    /// The message of the line read last.
    fn message(&mut self) -> Result<Option<Message>> {
        let mut words = self.lines.words();
        let Ok(kind) = words.word("message") else { return Ok(None) };
        Ok(Some(match kind {
            comment if comment.starts_with('#') => return Ok(None),
            "ODOM" => {
                let value = words.pose("pose")?;
                words.skip("velocities and acceleration", 3)?;
                Message::Odometry(Stamped { stamp: words.number("ipc_timestamp")?, value })
            }
            "TRUEPOS" => {
                let value = words.pose("true pose")?;
                words.skip("odometry", 3)?;
                Message::Truth(Stamped { stamp: words.number("ipc_timestamp")?, value })
            }
            "FLASER" => Message::Laser(front_laser(&mut words, &self.parameters)?),
            "ROBOTLASER1" => Message::Laser(robot_laser(&mut words)?),
            "PARAM" => {
                self.parameters = parameter(&mut words, self.parameters)?;
                return Ok(None);
            }
            _ => {
                self.skipped += 1;
                return Ok(None);
            }
        }))
    }

    /// The whole log, to be replayed.
    ///
    /// A laser pose with a constant offset to the odometry gives the mounting. If the offset is not
    /// constant, the log was corrected, and the laser's pose is the reference. `TRUEPOS` messages
    /// take precedence.
    ///
    /// # Errors
    /// An error in the log, with its place.
    pub fn laser_log(mut self) -> Result<LaserLog> {
        let messages: Vec<Message> = self.by_ref().collect::<Result<_>>()?;
        let lasers = || {
            messages.iter().filter_map(|message| match message {
                Message::Laser(laser) => Some(laser),
                _ => None,
            })
        };
        let kept_place = mounting(lasers());
        let mounting = kept_place.or(self.laser_offset()).unwrap_or_default();
        let is_truth = |message: &Message| matches!(message, Message::Truth(_));
        let corrected = kept_place.is_none() && !messages.iter().any(is_truth);
        let skipped = self.skipped();
        let notes = match skipped {
            0 => Vec::new(),
            _ => vec![format!("{skipped} messages of other kinds passed over")],
        };
        let entries = messages.into_iter().map(|message| match message {
            Message::Odometry(pose) => Entry::of_odometry(pose.stamp, pose.value),
            Message::Truth(pose) => Entry::of_truth(pose.stamp, pose.value),
            Message::Laser(laser) => {
                let scan = RecordedScan {
                    scan: Arc::new(laser.scan),
                    mounting,
                    odometry: laser.robot,
                    truth: corrected.then(|| laser.laser * mounting.inverse()),
                };
                Entry::of_scan(laser.stamp, scan)
            }
        });
        Ok(LaserLog { path: self.file().to_owned(), entries: entries.collect(), notes })
    }
}

/// `PARAM name value ..`; parameters of other modules change nothing.
fn parameter(words: &mut Words<'_>, mut known: LaserParameters) -> Result<LaserParameters> {
    match words.word("name of a parameter")? {
        "laser_front_laser_fov" => known.fov = Some(words.number("value")?.to_radians()),
        "laser_front_laser_resolution" => {
            known.resolution = Some(words.number("value")?.to_radians());
        }
        "robot_frontlaser_offset" => known.offset = Some(words.number("value")?),
        "robot_front_laser_max" => known.max_range = words.number("value")?,
        _ => {}
    }
    Ok(known)
}

impl Iterator for CarmenLog {
    type Item = Result<Message>;

    fn next(&mut self) -> Option<Result<Message>> {
        loop {
            match self.lines.advance() {
                Ok(true) => {}
                Ok(false) => return None,
                Err(error) => return Some(Err(error)),
            }
            if let Some(result) = self.message().transpose() {
                return Some(result);
            }
        }
    }
}

/// A scan with the poses that the log gives for it.
#[derive(Debug, Clone, PartialEq)]
pub struct CarmenLaser {
    /// Time of the scan \[s\].
    pub stamp: f64,
    /// The ranges, with +inf where nothing was in reach.
    pub scan: LaserScan,
    /// Pose of the laser: in a corrected log the reference, else the odometry.
    pub laser: Pose2,
    /// Pose of the robot in its odometry.
    pub robot: Pose2,
}

/// Parameters of the front laser in the log's `PARAM` lines.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LaserParameters {
    /// Opening angle \[rad\].
    fov: Option<f64>,
    /// Angle between two beams \[rad\].
    resolution: Option<f64>,
    /// Ranges from here on count as no return \[m\].
    max_range: f64,
    /// Distance ahead of the robot's centre \[m\].
    offset: Option<f64>,
}

impl Default for LaserParameters {
    fn default() -> Self {
        // The scanners of these logs report 81.9 m, and some drivers 80 m, where nothing returns.
        LaserParameters { fov: None, resolution: None, max_range: 80.0, offset: None }
    }
}

/// `FLASER n r1 .. rn x y theta odom_x odom_y odom_theta ipc_time host logger_time`
fn front_laser(words: &mut Words<'_>, given: &LaserParameters) -> Result<CarmenLaser> {
    let count = words.count("number of ranges", LaserScan::MAX_BEAMS)?;
    let ranges = words.numbers("range", count)?;
    let laser = words.pose("laser pose")?;
    let robot = words.pose("robot pose")?;
    let stamp = words.number("ipc_timestamp")?;
    // Half a turn, with a beam at both ends where their number is odd.
    let resolution = given.resolution.or_else(|| {
        let fov = given.fov.unwrap_or(PI);
        let steps = if count % 2 == 1 { count.saturating_sub(1).max(1) } else { count };
        (steps > 0).then(|| fov / steps as f64)
    });
    let start = -0.5 * given.fov.unwrap_or(PI);
    let scan = scan(words, ranges, start, resolution.unwrap_or(0.0), given.max_range)?;
    Ok(CarmenLaser { stamp, scan, laser, robot })
}

/// `ROBOTLASER1 type start_angle fov resolution max_range accuracy remission_mode n r1 .. rn m
/// s1 .. sm laser_x laser_y laser_theta robot_x robot_y robot_theta tv rv forward_safety_dist
/// side_safety_dist turn_axis ipc_time host logger_time`
fn robot_laser(words: &mut Words<'_>) -> Result<CarmenLaser> {
    words.skip("laser type", 1)?;
    let start = words.number("start angle")?;
    words.skip("field of view", 1)?;
    let resolution = words.number("angular resolution")?;
    let max_range = words.number("maximum range")?;
    words.skip("accuracy and remission mode", 2)?;
    let count = words.count("number of ranges", LaserScan::MAX_BEAMS)?;
    let ranges = words.numbers("range", count)?;
    let remissions = words.count("number of remissions", LaserScan::MAX_BEAMS)?;
    words.skip("remission", remissions)?;
    let laser = words.pose("laser pose")?;
    let robot = words.pose("robot pose")?;
    words.skip("velocities and safety distances", 5)?;
    let stamp = words.number("ipc_timestamp")?;
    let scan = scan(words, ranges, start, resolution, max_range)?;
    Ok(CarmenLaser { stamp, scan, laser, robot })
}

fn scan(
    words: &Words<'_>,
    mut ranges: Vec<f64>,
    angle_min: f64,
    angle_increment: f64,
    range_max: f64,
) -> Result<LaserScan> {
    for range in &mut ranges {
        if *range >= range_max {
            *range = f64::INFINITY;
        }
    }
    let scan = LaserScan {
        angle_min,
        angle_max: angle_min + angle_increment * ranges.len().saturating_sub(1) as f64,
        angle_increment,
        time_increment: 0.0,
        scan_time: 0.0,
        range_min: 0.0,
        range_max,
        ranges,
        intensities: Vec::new(),
    };
    scan.check().map_err(|error| words.error("scan", "a scan", &error.to_string()))?;
    Ok(scan)
}

/// Tolerance of a laser pose against the mounting \[m, rad\].
const ROUNDING: f64 = 1e-3;

/// Smallest turn of the robot that distinguishes a mounting from a correction \[rad\].
const MIN_TURN: f64 = 0.1;

/// The mounting of the laser, if its offset to the odometry is constant over the log.
fn mounting<'a>(lasers: impl Iterator<Item = &'a CarmenLaser> + Clone) -> Option<Pose2> {
    let place = |laser: &CarmenLaser| laser.robot.between(laser.laser);
    let first = lasers.clone().next()?;
    let at_first = place(first);
    let is_there = |at: Pose2| {
        let turn = angle::difference(at.theta, at_first.theta);
        at.distance(at_first) < ROUNDING && turn.abs() < ROUNDING
    };
    if !lasers.clone().all(|laser| is_there(place(laser))) {
        return None;
    }
    let turned = lasers.map(|laser| angle::difference(laser.robot.theta, first.robot.theta).abs());
    let on_the_robot = at_first == Pose2::IDENTITY || turned.fold(0.0, f64::max) > MIN_TURN;
    on_the_robot.then_some(at_first)
}
