//! Bags of ROS as recordings: how messages become events, and what the command does with them.

mod accuracy;
#[cfg(feature = "cli")]
mod command;
#[path = "../../../../loc-ros/tests/it/database.rs"]
pub(crate) mod database;
pub(crate) mod formats;
#[cfg(feature = "cli")]
mod late;
mod mcap_output;
#[cfg(feature = "cli")]
mod memory;
#[cfg(feature = "cli")]
mod python;
mod recording;
mod sensors;
#[path = "../../../../loc-ros/tests/it/write.rs"]
pub(crate) mod write;

use loc_ros::{Channel, MessageReader};

/// A message with its channel.
pub(crate) type Read = (Channel, i64, Vec<u8>);

/// All messages of a bag, and its notes.
pub(crate) fn all(bag: &mut dyn MessageReader) -> (Vec<Read>, Vec<String>) {
    let mut messages = Vec::new();
    while let Some(message) = bag.next_message().unwrap() {
        let (channel, time, data) = (message.channel, message.log_time, message.data.to_vec());
        messages.push((bag.channels()[channel].clone(), time, data));
    }
    let notes = bag.notes();
    (messages, notes)
}
