//! What every kind of bag gives: channels, and messages as bytes.

use crate::bag1::{self, Bag1};
use crate::bag2::{self, Bag2, Database3};
use crate::mcap::{self, McapReader};
use crate::messages::Stamp;
use crate::sqlite;
use crate::{Error, Result};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Whether a file or folder is a bag, by its first bytes or its files.
///
/// # Errors
/// [`loc_core::Error::Io`].
pub fn is_bag(path: &Path) -> Result<bool> {
    if path.is_dir() {
        return Ok(bag2::is_bag(path));
    }
    let head = first_bytes(path)?;
    let magics: [&[u8]; 3] = [bag1::MAGIC, sqlite::MAGIC, &mcap::MAGIC];
    Ok(magics.iter().any(|magic| head.starts_with(magic)))
}

/// Opens a bag: a folder of ROS 2, a file `.db3` or `.mcap`, a bag of ROS 1.
///
/// # Errors
/// [`loc_core::Error::Io`], and [`Error::Recording`] for what is none of these.
pub fn open(path: &Path) -> Result<Box<dyn MessageReader>> {
    if path.is_dir() { Ok(Box::new(Bag2::open(path)?)) } else { open_file(path) }
}

pub(crate) fn open_file(path: &Path) -> Result<Box<dyn MessageReader>> {
    let head = first_bytes(path)?;
    if head.starts_with(bag1::MAGIC) {
        return Ok(Box::new(Bag1::open(path)?));
    }
    if head.starts_with(sqlite::MAGIC) {
        return Ok(Box::new(Database3::open(path)?));
    }
    if head.starts_with(&mcap::MAGIC) {
        return Ok(Box::new(McapReader::open(path)?));
    }
    Err(Error::Recording {
        path: path.to_owned(),
        expected: "a bag: MCAP, SQLite (.db3) or ROS 1 (\"#ROSBAG V2.0\")".into(),
        found: match head.as_slice() {
            [] => "an empty file".into(),
            _ => format!("a file that starts with {:?}", String::from_utf8_lossy(&head)),
        },
    })
}

fn first_bytes(path: &Path) -> Result<Vec<u8>> {
    let mut head = Vec::new();
    let file = File::open(path).map_err(loc_core::Error::io(path))?;
    file.take(16).read_to_end(&mut head).map_err(loc_core::Error::io(path))?;
    Ok(head)
}

/// How the bytes of a channel's messages are laid out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Encoding {
    /// The Common Data Representation of ROS 2.
    Cdr,
    /// The serialisation of ROS 1.
    Ros1,
    /// Another one, which is not read.
    Other(String),
}

impl Encoding {
    pub(crate) fn named(name: &str) -> Self {
        match name {
            "cdr" => Encoding::Cdr,
            "ros1" => Encoding::Ros1,
            other => Encoding::Other(other.to_owned()),
        }
    }
}

/// A topic with the type of its messages, from one publisher.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Channel {
    /// The topic, such as `/scan`.
    pub topic: String,
    /// The type as the bag names it: `sensor_msgs/msg/LaserScan`, or without `msg` from ROS 1.
    pub type_name: String,
    /// How the messages are laid out.
    pub encoding: Encoding,
}

impl Channel {
    /// Whether the messages are of a type, given as `sensor_msgs/msg/LaserScan`.
    pub fn is_of(&self, type_name: &str) -> bool {
        let mut own = self.type_name.split('/');
        let mut given = type_name.split('/');
        own.next() == given.next() && own.next_back() == given.next_back()
    }
}

/// A message as it lies in the bag.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RawMessage<'a> {
    /// Index of its channel.
    pub channel: usize,
    /// When it was recorded \[ns since 1970, or of the simulated clock\].
    pub log_time: i64,
    /// Its bytes, in the channel's encoding.
    pub data: &'a [u8],
}

/// A bag as a stream of messages, in the order in which they were recorded.
///
/// No more is held in memory than one chunk of the bag, whatever its length. A bag that breaks off
/// is read up to the break; [`MessageReader::notes`] then says where that is.
pub trait MessageReader {
    /// The file or folder.
    fn path(&self) -> &Path;

    /// The channels known so far; a message names its channel by index.
    fn channels(&self) -> &[Channel];

    /// The next message, `None` at the end.
    ///
    /// # Errors
    /// [`crate::Error::Recording`] with the byte at which the bag cannot be what it claims.
    fn next_message(&mut self) -> Result<Option<RawMessage<'_>>>;

    /// The share of the bytes that is read, in \[0, 1\].
    fn progress(&self) -> f64;

    /// What was passed over, and where the bag breaks off, as lines for the user.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}

/// The topics of a bag, counted.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Survey {
    /// In the order in which they appear in the bag.
    pub topics: Vec<Topic>,
    /// Where the bag breaks off, and what was passed over.
    pub notes: Vec<String>,
}

/// A topic with its messages.
#[derive(Debug, Clone, PartialEq)]
pub struct Topic {
    /// Its name, type and encoding.
    pub channel: Channel,
    /// Number of messages.
    pub count: u64,
    /// Their bytes.
    pub bytes: u64,
    /// When the first and the last of them were recorded.
    pub span: Option<(Stamp, Stamp)>,
}

impl Topic {
    /// Messages a second, of a topic with at least two at different times.
    pub fn rate(&self) -> Option<f64> {
        let (first, last) = self.span?;
        let seconds = last.seconds_since(first);
        (seconds > 0.0 && self.count > 1).then(|| (self.count - 1) as f64 / seconds)
    }

    fn add(&mut self, message: &RawMessage<'_>) {
        let at = Stamp(message.log_time);
        let (first, last) = self.span.unwrap_or((at, at));
        self.span = Some((first.min(at), last.max(at)));
        self.count += 1;
        self.bytes += message.data.len() as u64;
    }
}

impl Survey {
    /// Reads a bag to its end; `observe` gets every message, with its channel.
    ///
    /// # Errors
    /// What the bag reports.
    pub fn of(
        bag: &mut dyn MessageReader,
        observe: &mut dyn FnMut(&Channel, &RawMessage<'_>),
        progress: &mut dyn FnMut(f64),
    ) -> Result<Self> {
        let mut survey = Survey::default();
        let (mut count, mut data) = (0_u32, Vec::new());
        loop {
            count = count.wrapping_add(1);
            if count.is_multiple_of(256) {
                progress(bag.progress());
            }
            let Some(message) = bag.next_message()? else { break };
            let (index, log_time) = (message.channel, message.log_time);
            data.clear();
            data.extend_from_slice(message.data);
            survey.add(bag.channels());
            if let Some(topic) = survey.topics.get_mut(index) {
                let message = RawMessage { channel: index, log_time, data: &data };
                topic.add(&message);
                observe(&topic.channel, &message);
            }
        }
        survey.add(bag.channels());
        survey.notes = bag.notes();
        Ok(survey)
    }

    /// Adds the channels that are not known yet; any message may bring some.
    fn add(&mut self, channels: &[Channel]) {
        for channel in channels.iter().skip(self.topics.len()) {
            let channel = channel.clone();
            self.topics.push(Topic { channel, count: 0, bytes: 0, span: None });
        }
    }

    /// From the first message to the last.
    pub fn span(&self) -> Option<(Stamp, Stamp)> {
        let spans = || self.topics.iter().filter_map(|topic| topic.span);
        Some((spans().map(|span| span.0).min()?, spans().map(|span| span.1).max()?))
    }

    /// Number of messages.
    pub fn count(&self) -> u64 {
        self.topics.iter().map(|topic| topic.count).sum()
    }
}
