//! Bags of ROS 2: a folder with `metadata.yaml` and files of one of two formats.
//!
//! `.db3` files are SQLite databases with a table of topics and one of messages, `.mcap` files are
//! read by [`McapReader`](super::McapReader). A folder without `metadata.yaml` (a recorder that was
//! killed writes none) is taken to hold the files that lie in it.

mod database;
mod metadata;

pub use database::Database3;

use super::bag::{Channel, MessageReader, RawMessage};
use super::compression::{Compression, Unpacked};
use crate::Result;
use metadata::Metadata;
use std::path::{Path, PathBuf};

/// Longest message that is unpacked for itself \[bytes\].
const MAX_MESSAGE: u64 = 1 << 28;

/// Whether a folder is a bag of ROS 2.
pub(super) fn is_bag(folder: &Path) -> bool {
    folder.join("metadata.yaml").is_file()
        || metadata::files_in(folder).is_ok_and(|f| !f.is_empty())
}

/// A folder of ROS 2, its files one after the other.
pub struct Bag2 {
    path: PathBuf,
    files: std::vec::IntoIter<PathBuf>,
    number_of_files: usize,
    current: Option<Box<dyn MessageReader>>,
    channels: Vec<Channel>,
    /// Index here of each channel of the current file.
    indices: Vec<usize>,
    /// Whether every message is packed for itself.
    packed: bool,
    /// The message read last.
    data: Vec<u8>,
    bad_messages: u64,
    notes: Vec<String>,
}

impl Bag2 {
    /// Opens a folder.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`], and [`crate::Error::Recording`] for a folder that is no bag.
    pub fn open(path: &Path) -> Result<Self> {
        let Metadata { files, packed, notes } = Metadata::of(path)?;
        Ok(Bag2 {
            path: path.to_owned(),
            number_of_files: files.len(),
            files: files.into_iter(),
            current: None,
            channels: Vec::new(),
            indices: Vec::new(),
            packed,
            data: Vec::new(),
            bad_messages: 0,
            notes,
        })
    }

    /// Opens the next file; false where there is none.
    fn next_file(&mut self) -> Result<bool> {
        let name =
            |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if let Some(done) = self.current.take() {
            let name = name(done.path());
            self.notes.extend(done.notes().into_iter().map(|note| format!("{name}: {note}")));
        }
        let Some(file) = self.files.next() else { return Ok(false) };
        if std::fs::metadata(&file).is_ok_and(|file| file.len() == 0) {
            // A recorder that was killed had not written anything yet.
            self.notes.push(format!("{}: is empty: passed over", name(&file)));
            return Ok(true);
        }
        self.current = Some(super::open_file(&file)?);
        self.indices.clear();
        Ok(true)
    }
}

/// Unpacks a message; false for one that cannot be. How long it is, its packed bytes say.
fn unpack(packed: &[u8], into: &mut Vec<u8>) -> bool {
    Compression::Zstd.unpack(packed, MAX_MESSAGE, into) != Unpacked::TooMuch && !into.is_empty()
}

/// Index of a channel among the known ones; a new one is added.
fn index_of(channels: &mut Vec<Channel>, channel: &Channel) -> usize {
    channels.iter().position(|known| known == channel).unwrap_or_else(|| {
        channels.push(channel.clone());
        channels.len() - 1
    })
}

impl MessageReader for Bag2 {
    fn path(&self) -> &Path {
        &self.path
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn next_message(&mut self) -> Result<Option<RawMessage<'_>>> {
        let (channel, log_time) = loop {
            let Some(current) = &mut self.current else {
                if !self.next_file()? {
                    return Ok(None);
                }
                continue;
            };
            let Some(message) = current.next_message()? else {
                if !self.next_file()? {
                    return Ok(None);
                }
                continue;
            };
            let (own, log_time) = (message.channel, message.log_time);
            if !self.packed {
                self.data.clear();
                self.data.extend_from_slice(message.data);
            } else if !unpack(message.data, &mut self.data) {
                self.bad_messages += 1;
                continue;
            }
            for channel in current.channels().iter().skip(self.indices.len()) {
                self.indices.push(index_of(&mut self.channels, channel));
            }
            if let Some(index) = self.indices.get(own) {
                break (*index, log_time);
            }
        };
        Ok(Some(RawMessage { channel, log_time, data: &self.data }))
    }

    fn progress(&self) -> f64 {
        let left = self.files.len();
        let done = self.number_of_files - left - usize::from(self.current.is_some());
        let within = self.current.as_ref().map_or(0.0, |current| current.progress());
        (done as f64 + within) / self.number_of_files.max(1) as f64
    }

    fn notes(&self) -> Vec<String> {
        let bad = (self.bad_messages > 0)
            .then(|| format!("{} packed messages cannot be unpacked", self.bad_messages));
        let current = self.current.iter().flat_map(|current| current.notes());
        self.notes.iter().cloned().chain(current).chain(bad).collect()
    }
}
