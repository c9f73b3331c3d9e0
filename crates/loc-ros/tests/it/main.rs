//! Tests of `loc-ros` through its public face, one module per topic.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::float_cmp)]

mod damage;
mod database;
mod foreign;
mod mcap;
mod real;
mod serialization;
mod tf;
mod transcribe;
#[allow(dead_code, reason = "tests of loc-sim and the benches use the rest")]
mod write;

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
