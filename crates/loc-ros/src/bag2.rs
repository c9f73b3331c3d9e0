//! Bags of ROS 2: a folder with `metadata.yaml` and files of one of two formats.
//!
//! `.db3` files are SQLite databases with a table of topics and one of messages, `.mcap` files are
//! read by [`McapReader`](crate::McapReader). A folder without `metadata.yaml` (a recorder that was
//! killed writes none) is taken to hold the files that lie in it.

use crate::bag::{self, Channel, Encoding, MessageReader, RawMessage};
use crate::compression::{Compression, Unpacked};
use crate::sqlite::{Database, Row, Table, TableScan, Value};
use crate::{Error, Result};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};

/// Longest message that is unpacked for itself \[bytes\].
const MAX_MESSAGE: u64 = 1 << 28;

/// Whether a folder is a bag of ROS 2.
pub(crate) fn is_bag(folder: &Path) -> bool {
    folder.join("metadata.yaml").is_file() || files_in(folder).is_ok_and(|f| !f.is_empty())
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
        self.current = Some(bag::open_file(&file)?);
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

/// What is read of `metadata.yaml`.
#[derive(Debug, Deserialize)]
struct MetadataFile {
    rosbag2_bagfile_information: Information,
}

#[derive(Debug, Deserialize)]
struct Information {
    #[serde(default)]
    relative_file_paths: Vec<String>,
    #[serde(default)]
    compression_format: String,
    #[serde(default)]
    compression_mode: String,
}

/// The files of a bag.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Metadata {
    files: Vec<PathBuf>,
    /// Whether every message is packed by zstd.
    packed: bool,
    notes: Vec<String>,
}

impl Metadata {
    fn of(folder: &Path) -> Result<Self> {
        let file = folder.join("metadata.yaml");
        if !file.is_file() {
            let files = files_in(folder)?;
            if files.is_empty() {
                return Err(unsuitable(folder, "metadata.yaml, or files .db3 or .mcap", "neither"));
            }
            let notes = vec!["has no metadata.yaml: its files are taken in order of name".into()];
            return Ok(Metadata { files, packed: false, notes });
        }
        let text = std::fs::read_to_string(&file).map_err(loc_core::Error::io(&file))?;
        Metadata::parse(folder, &file, &text)
    }

    fn parse(folder: &Path, file: &Path, text: &str) -> Result<Self> {
        let parsed: MetadataFile = serde_saphyr::from_str(text).map_err(|cause| {
            let cause = cause.to_string();
            let cause = cause.lines().next().unwrap_or_default();
            unsuitable(file, "rosbag2_bagfile_information with relative_file_paths", cause)
        })?;
        let information = parsed.rosbag2_bagfile_information;
        let mode = information.compression_mode.to_uppercase();
        let format = information.compression_format;
        let packed = match (mode.as_str(), format.as_str()) {
            ("" | "NONE", _) => false,
            ("MESSAGE", "zstd") if cfg!(feature = "zstd") => true,
            ("FILE", _) => {
                let expected = "files that are not packed as a whole (unpack them with `zstd -d` \
                                and take the ending off in metadata.yaml)";
                return Err(unsuitable(file, expected, format!("files packed by {format}")));
            }
            _ => {
                let found = format!("mode {mode}, format {format}");
                return Err(unsuitable(file, "messages packed by zstd", found));
            }
        };
        // Some recorders write the folder's name in front.
        let place = |name: &String| {
            let direct = folder.join(name);
            match direct.is_file() {
                true => direct,
                false => folder.join(Path::new(name).file_name().unwrap_or_default()),
            }
        };
        let files: Vec<PathBuf> = information.relative_file_paths.iter().map(place).collect();
        if files.is_empty() {
            return Err(unsuitable(file, "relative_file_paths with at least one file", "none"));
        }
        Ok(Metadata { files, packed, notes: Vec::new() })
    }
}

/// The files of a folder that can be part of a bag, `_2` before `_10`.
fn files_in(folder: &Path) -> Result<Vec<PathBuf>> {
    let io = || loc_core::Error::io(folder);
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io())? {
        let path = entry.map_err(io())?.path();
        if path.extension().is_some_and(|ending| ending == "db3" || ending == "mcap") {
            files.push(path);
        }
    }
    files.sort_by_key(|path| {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let number = stem.rsplit('_').next().and_then(|digits| digits.parse::<u64>().ok());
        (number, stem)
    });
    Ok(files)
}

fn unsuitable(path: &Path, expected: &str, found: impl Into<String>) -> Error {
    Error::Recording { path: path.to_owned(), expected: expected.into(), found: found.into() }
}

/// A database of messages, read row by row in the order in which they were written.
#[derive(Debug)]
pub struct Database3 {
    database: Database,
    channels: Vec<Channel>,
    /// Index of the channel of each topic.
    topics: BTreeMap<i64, usize>,
    messages: Table,
    /// Columns of topic, time and data.
    columns: [usize; 3],
    scan: TableScan,
    row: Row,
    without_topic: u64,
}

impl Database3 {
    /// Opens a file.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`], and [`crate::Error::Recording`] for a file that is no such database.
    pub fn open(path: &Path) -> Result<Self> {
        Database3::new(Database::open(path)?)
    }

    /// A database from anything that can be read; `path` is only named in errors.
    ///
    /// # Errors
    /// As [`Database3::open`].
    pub fn read(path: &Path, bytes: impl Read + Seek + 'static) -> Result<Self> {
        Database3::new(Database::read(path, bytes)?)
    }

    fn new(mut database: Database) -> Result<Self> {
        let (channels, topics) = topics(&mut database)?;
        let (messages, columns) =
            table(&mut database, "messages", ["topic_id", "timestamp", "data"])?;
        let scan = messages.scan();
        Ok(Database3 {
            database,
            channels,
            topics,
            messages,
            columns,
            scan,
            row: Row::default(),
            without_topic: 0,
        })
    }

    /// Reads rows until there is a message: its channel and its time.
    fn advance(&mut self) -> Result<Option<(usize, i64)>> {
        while let Some(row) = self.database.next(&mut self.scan)? {
            self.row = row;
            let value = |column| self.messages.value(&self.row, column);
            let [topic, time, _] = self.columns;
            let (Value::Integer(topic), Value::Integer(time)) = (value(topic), value(time)) else {
                self.without_topic += 1;
                continue;
            };
            match self.topics.get(&topic) {
                Some(channel) => return Ok(Some((*channel, time))),
                None => self.without_topic += 1,
            }
        }
        Ok(None)
    }
}

/// A table with the places of some of its columns.
fn table<const N: usize>(
    database: &mut Database,
    name: &str,
    columns: [&str; N],
) -> Result<(Table, [usize; N])> {
    let Some(table) = database.table(name)? else {
        return Err(database.error(&format!("a table `{name}`, as bags of ROS 2 have"), "none"));
    };
    let mut places = [0; N];
    for (place, column) in places.iter_mut().zip(columns) {
        *place = table.column(column).ok_or_else(|| {
            database.error(&format!("a column `{column}` of the table `{name}`"), "none")
        })?;
    }
    Ok((table, places))
}

type Topics = (Vec<Channel>, BTreeMap<i64, usize>);

fn topics(database: &mut Database) -> Result<Topics> {
    let names = ["id", "name", "type", "serialization_format"];
    let (table, columns) = table(database, "topics", names)?;
    let (mut channels, mut topics) = (Vec::new(), BTreeMap::new());
    let mut scan = table.scan();
    while let Some(row) = database.next(&mut scan)? {
        let text = |column| match table.value(&row, column) {
            Value::Text(text) => String::from_utf8_lossy(text).into_owned(),
            _ => String::new(),
        };
        let [id, name, type_name, format] = columns;
        if let Value::Integer(id) = table.value(&row, id) {
            topics.insert(id, channels.len());
            channels.push(Channel {
                topic: text(name),
                type_name: text(type_name),
                encoding: Encoding::named(&text(format)),
            });
        }
    }
    Ok((channels, topics))
}

impl MessageReader for Database3 {
    fn path(&self) -> &Path {
        self.database.path()
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn next_message(&mut self) -> Result<Option<RawMessage<'_>>> {
        let Some((channel, log_time)) = self.advance()? else { return Ok(None) };
        let data = match self.messages.value(&self.row, self.columns[2]) {
            Value::Blob(data) | Value::Text(data) => data,
            _ => &[],
        };
        Ok(Some(RawMessage { channel, log_time, data }))
    }

    fn progress(&self) -> f64 {
        self.database.progress()
    }

    fn notes(&self) -> Vec<String> {
        let breaks_off = self
            .database
            .breaks_off()
            .map(|page| format!("breaks off before page {page} of the database: read up to there"));
        let count = self.without_topic;
        let without = (count > 0).then(|| format!("{count} messages without a topic passed over"));
        breaks_off.into_iter().chain(without).collect()
    }
}
