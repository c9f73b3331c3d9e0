//! A recording as an MCAP file of ROS 2.

use super::{Converted, LeftOut, each};
use crate::Result;
use crate::output::mcap::McapRecorder;
use crate::runner::Observer;
use crate::source::Source;
use loc_sensors::event::{Measurement, Payload};
use std::path::Path;

/// Writes the topics `/odom`, `/scan`, `/scan_points`, `/tf`, `/tf_static` and `/ground_truth`, and
/// `/landmarks` where the recording has a map of them.
///
/// # Errors
/// What the source reports, and [`loc_core::Error::Io`].
pub fn to_mcap(
    source: &mut dyn Source,
    out: &Path,
    progress: &mut dyn FnMut(f64),
) -> Result<Converted> {
    let mut recorder = McapRecorder::create(out)?;
    let mut left_out = LeftOut::default();
    recorder.started(source.setup(), &[])?;
    each(source, progress, |event| {
        match &event.payload {
            Payload::Measurement(Measurement::Scan { .. }) | Payload::Truth(_) => {}
            Payload::Measurement(_) => left_out.count("measurements that are no scans"),
            Payload::Control(_) => {}
        }
        recorder.event(event)
    })?;
    let written = recorder.finish()?;
    Ok(Converted { written, left_out: left_out.with_notes(source) })
}
