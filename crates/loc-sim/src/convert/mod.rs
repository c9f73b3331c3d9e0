//! Recordings from one format to another, as far as the target has a place for what they hold.
//!
//! | to | from | holds |
//! |---|---|---|
//! | [`to_tum`] | any recording | one track: the reference, or else the odometry |
//! | [`to_carmen`] | any recording | odometry, scans of lasers, true poses |
//! | [`to_mcap`] | any recording | odometry, scans, true poses, as messages of ROS 2 |
//! | [`loc_ros::transcribe`] | a bag | its own messages under their own topics, as an MCAP file of ROS 2 |
//!
//! A conversion reads the recording as a stream, and says in [`Converted`] what it wrote and what
//! it had to leave out.
//!
//! ```
//! use loc_sim::convert::to_tum;
//! use loc_sim::source::carmen::CarmenLog;
//! use loc_sim::source::laser_log::{LaserRecording, ReplayOptions, Start};
//! let text = "FLASER 3 1 2 3 0.1 0 0 5 5 0 10 host 10\nFLASER 3 1 2 3 0.6 0 0 5.5 5 0.1 11 host 11\n";
//! let log = CarmenLog::parse("demo.log", text.as_bytes()).laser_log()?;
//! let options = ReplayOptions { start: Start::Anywhere, ..ReplayOptions::default() };
//! let mut recording = LaserRecording::new(log, &options)?;
//! let (track, converted) = to_tum(&mut recording, None, &mut |_| {})?;
//! assert_eq!(track.len(), 2);
//! assert_eq!(converted.written, 2);
//! # Ok::<(), loc_sim::Error>(())
//! ```

mod carmen;
mod left_out;
mod mcap;
mod tum;

pub use carmen::to_carmen;
pub use mcap::to_mcap;
pub use tum::{Track, to_tum};

use crate::Result;
use crate::source::Source;
use loc_sensors::event::Event;

/// What a conversion did.
#[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize)]
pub struct Converted {
    /// Number of messages, lines or poses written.
    pub written: u64,
    /// What the target has no place for, as counted lines for the user.
    pub left_out: Vec<String>,
}

impl From<loc_ros::Transcribed> for Converted {
    fn from(transcribed: loc_ros::Transcribed) -> Self {
        Converted { written: transcribed.written, left_out: transcribed.left_out }
    }
}

/// Shows every event of a recording to `take`, and the share of its time that has passed to
/// `progress`.
fn each(
    source: &mut dyn Source,
    progress: &mut dyn FnMut(f64),
    mut take: impl FnMut(&Event) -> Result<()>,
) -> Result<()> {
    let (start, end) = (source.setup().start, source.setup().end);
    while let Some(event) = source.next_event()? {
        take(&event)?;
        if end > start {
            progress(((event.stamp - start) / (end - start)).clamp(0.0, 1.0));
        }
    }
    Ok(())
}
