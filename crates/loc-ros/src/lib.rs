#![doc = include_str!("../README.md")]

pub mod bag;
mod bag1;
mod bag2;
mod bytes;
mod compression;
mod error;
mod mcap;
pub mod messages;
pub mod parameters;
pub mod recording;
mod serialization;
mod sqlite;
pub mod tf;
mod transcribe;

pub use bag::{Channel, Encoding, MessageReader, RawMessage, Survey, Topic, is_bag, open};
pub use bag1::Bag1;
pub use bag2::{Bag2, Database3};
pub use error::{Error, Result};
pub use mcap::{McapReader, McapWriter};
pub use parameters::{Found, NodeParameters};
pub use recording::{Moment, Recording, RecordingOptions, RosNames};
pub use serialization::{Decoder, Dialect, Encoder};
pub use transcribe::{Transcribed, transcribe};
