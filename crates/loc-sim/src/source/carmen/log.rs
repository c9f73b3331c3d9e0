//! The log as a stream of messages.

use super::laser::{LaserParameters, front_laser, robot_laser};
use super::{CarmenLaser, Message};
use crate::Result;
use crate::source::laser_log::{self, LogLines, Words};
use loc_core::{Pose2, Stamped};
use std::io::BufRead;
use std::path::{Path, PathBuf};

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
        Ok(CarmenLog::parse(file, laser_log::open(file)?))
    }

    /// A log from anything that can be read; `file` is only named in errors.
    pub fn parse(file: impl Into<PathBuf>, lines: impl BufRead + 'static) -> Self {
        let lines = LogLines::new(file, lines);
        CarmenLog { lines, parameters: LaserParameters::default(), skipped: 0 }
    }

    /// How many messages of other kinds were passed over so far.
    pub fn skipped(&self) -> usize {
        self.skipped
    }

    /// Where a `PARAM` read so far says that the front laser sits on the robot.
    pub fn laser_offset(&self) -> Option<Pose2> {
        self.parameters.offset.map(|ahead| Pose2::new(ahead, 0.0, 0.0))
    }

    pub(super) fn file(&self) -> &Path {
        self.lines.file()
    }

    /// The scans of the whole log.
    ///
    /// # Errors
    /// What is wrong with the log, and where.
    pub fn lasers(self) -> Result<Vec<CarmenLaser>> {
        let scans = self.filter_map(|message| match message {
            Ok(Message::Laser(laser)) => Some(Ok(laser)),
            Ok(_) => None,
            Err(error) => Some(Err(error)),
        });
        scans.collect()
    }

    /// What the line read last says.
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
