//! One track of a recording.

use super::left_out::LeftOut;
use super::{Converted, each};
use crate::odometry::Driven;
use crate::source::Source;
use crate::{Error, Result};
use loc_core::Trajectory;
use loc_sensors::event::Payload;

/// Which track of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Track {
    /// The true poses, in the map.
    Reference,
    /// The robot's odometry, in its own frame.
    Odometry,
}

/// A track of a recording, the reference where there is one and nothing else is asked for.
///
/// Velocities are driven along from (0, 0, 0). Of several poses of one time the first is taken.
///
/// # Errors
/// [`Error::Recording`] for a recording without such a track, and what the source reports.
pub fn to_tum(
    source: &mut dyn Source,
    track: Option<Track>,
    progress: &mut dyn FnMut(f64),
) -> Result<(Trajectory, Converted)> {
    let preferred = if source.has_truth() { Track::Reference } else { Track::Odometry };
    let track = track.unwrap_or(preferred);
    let (mut poses, mut left_out) = (Trajectory::new(), LeftOut::default());
    let mut driven = Driven::default();
    each(source, progress, |event| {
        let pose = match (&event.payload, track) {
            (Payload::Truth(truth), Track::Reference) => truth.pose,
            (Payload::Control(control), Track::Odometry) => match driven.pose(event.stamp, control)
            {
                Some(pose) => pose,
                None => return Ok(()),
            },
            _ => return Ok(()),
        };
        match poses.last() {
            Some(last) if last.stamp >= event.stamp => {
                left_out.count("poses that are not later than the one before");
                Ok(())
            }
            _ => Ok(poses.push(event.stamp, pose)?),
        }
    })?;
    if poses.is_empty() {
        return Err(Error::Recording {
            path: source.setup().name.clone().into(),
            expected: match track {
                Track::Reference => "true poses".into(),
                Track::Odometry => "odometry".into(),
            },
            found: "none".into(),
        });
    }
    let mut left_out = left_out.with_notes(source);
    if track == Track::Reference && !source.truth_has_heading() {
        left_out.push("the reference has no headings: they are written as 0".into());
    }
    let written = poses.len() as u64;
    Ok((poses, Converted { written, left_out }))
}
