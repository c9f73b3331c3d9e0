//! Recordings of ROS: bags of ROS 1, bags of ROS 2 (SQLite and MCAP), and MCAP files.
//!
//! A bag is a row of messages, each of a topic, with bytes whose layout the topic's type says.
//! [`open`] gives them one after the other, whatever the format; [`messages`] makes fields of the
//! bytes; [`tf`] knows where one frame was in another at any time; [`RosRecording`] joins scans,
//! odometry and frames to the stream of events that every method understands.
//!
//! Nothing that a file claims is believed: lengths are held against what is left of the file, so
//! that no bag makes a reader panic or take more memory than a chunk needs.
//!
//! ```no_run
//! use loc_sim::source::ros::messages::{LaserScan, Message};
//! use std::path::Path;
//! let mut bag = loc_sim::source::ros::open(Path::new("my_bag"))?;
//! while let Some(message) = bag.next_message()? {
//!     let (channel, data, log_time) = (message.channel, message.data.to_vec(), message.log_time);
//!     let channel = &bag.channels()[channel];
//!     if channel.is_of(LaserScan::NAME) {
//!         let scan = LaserScan::from_bytes(&data, &channel.encoding)?;
//!         println!("{log_time} {}: {} beams", channel.topic, scan.ranges.len());
//!     }
//! }
//! # Ok::<(), loc_sim::Error>(())
//! ```

mod bag;
mod bag1;
mod bag2;
mod compression;
mod fields;
mod input;
mod mcap;
pub mod messages;
mod recording;
mod serialization;
mod sqlite;
mod survey;
pub mod tf;

pub use bag::{Channel, Encoding, MessageReader, RawMessage};
pub use bag1::Bag1;
pub use bag2::{Bag2, Database3};
pub use mcap::{McapReader, McapWriter};
pub use recording::{OdometryDelay, RosNames, RosOptions, RosRecording, laser_log};
pub use serialization::{Decoder, Dialect, Encoder};
pub use survey::{Survey, Topic};

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

fn open_file(path: &Path) -> Result<Box<dyn MessageReader>> {
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
