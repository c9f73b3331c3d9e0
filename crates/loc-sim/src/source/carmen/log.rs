//! The log as a stream of messages.

use super::laser::{LaserParameters, front_laser, robot_laser};
use super::line::Words;
use super::{CarmenLaser, Message};
use crate::Result;
use flate2::bufread::MultiGzDecoder;
use loc_core::{Error, Stamped};
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// Longest line of a log; a longer one is no CARMEN message.
const LONGEST_LINE: u64 = 32 << 20;

/// A CARMEN log, read message by message.
pub struct CarmenLog {
    file: PathBuf,
    lines: Box<dyn BufRead>,
    line: usize,
    parameters: LaserParameters,
    skipped: usize,
}

impl CarmenLog {
    /// Opens a log; gzipped ones are unpacked as they are read.
    ///
    /// # Errors
    /// [`Error::Io`] where the file cannot be opened.
    pub fn open(file: impl AsRef<Path>) -> Result<Self> {
        let file = file.as_ref();
        let mut bytes = BufReader::new(File::open(file).map_err(Error::io(file))?);
        let gzipped = bytes.fill_buf().map_err(Error::io(file))?.starts_with(&[0x1f, 0x8b]);
        Ok(if gzipped {
            CarmenLog::parse(file, BufReader::new(MultiGzDecoder::new(bytes)))
        } else {
            CarmenLog::parse(file, bytes)
        })
    }

    /// A log from anything that can be read; `file` is only named in errors.
    pub fn parse(file: impl Into<PathBuf>, lines: impl BufRead + 'static) -> Self {
        CarmenLog {
            file: file.into(),
            lines: Box::new(lines),
            line: 0,
            parameters: LaserParameters::default(),
            skipped: 0,
        }
    }

    /// How many messages of other kinds were passed over so far.
    pub fn skipped(&self) -> usize {
        self.skipped
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

    fn message(&mut self, text: &str) -> Result<Option<Message>> {
        let mut words = Words::new(&self.file, self.line, text);
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
        "robot_front_laser_max" => known.max_range = words.number("value")?,
        _ => {}
    }
    Ok(known)
}

impl Iterator for CarmenLog {
    type Item = Result<Message>;

    fn next(&mut self) -> Option<Result<Message>> {
        loop {
            let mut bytes = Vec::new();
            self.line += 1;
            let read = self.lines.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut bytes);
            match read {
                Ok(0) => return None,
                Err(error) => return Some(Err(Error::io(&self.file)(error).into())),
                Ok(_) => {}
            }
            // A host name may hold anything; the numbers are ASCII.
            match self.message(&String::from_utf8_lossy(&bytes)).transpose() {
                Some(result) => return Some(result),
                None => continue,
            }
        }
    }
}

impl std::fmt::Debug for CarmenLog {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("CarmenLog").field("file", &self.file).field("line", &self.line).finish()
    }
}
