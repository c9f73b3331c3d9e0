//! What every kind of bag gives: channels, and messages as bytes.

use crate::Result;
use std::path::Path;

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
    pub(super) fn named(name: &str) -> Self {
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
        let mut asked = type_name.split('/');
        own.next() == asked.next() && own.next_back() == asked.next_back()
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
