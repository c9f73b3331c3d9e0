//! Bags of ROS: what others wrote, what is damaged, and how messages become events.

mod accuracy;
mod damage;
mod foreign;
mod late;
mod mcap_output;
mod real;
mod recording;
mod serialization;
mod tf;
mod transcribe;
mod write;

use loc_sim::source::ros::{Channel, MessageReader};

/// A message with its channel.
type Read = (Channel, i64, Vec<u8>);

/// All messages of a bag, and its notes.
fn all(bag: &mut dyn MessageReader) -> (Vec<Read>, Vec<String>) {
    let mut messages = Vec::new();
    while let Some(message) = bag.next_message().unwrap() {
        let (channel, time, data) = (message.channel, message.log_time, message.data.to_vec());
        messages.push((bag.channels()[channel].clone(), time, data));
    }
    let notes = bag.notes();
    (messages, notes)
}
