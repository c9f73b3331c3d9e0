//! Bags of ROS: what others wrote, what is damaged, and how messages become events.

mod accuracy;
mod checksums;
#[cfg(feature = "cli")]
mod command;
mod damage;
pub(crate) mod database;
pub(crate) mod foreign;
mod formats;
#[cfg(feature = "cli")]
mod late;
mod mcap_output;
#[cfg(feature = "cli")]
mod memory;
#[cfg(feature = "cli")]
mod python;
mod real;
mod recording;
mod sensors;
mod serialization;
mod tf;
mod transcribe;
pub(crate) mod write;

use loc_sim::source::ros::{Channel, MessageReader};

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
