//! Names of frames in a parameter file, looked for in a bag.

use super::RosNames;
use super::preview::Preview;
use super::roles::{OdometryFrom, plain};
use crate::source::ros::messages::{self, Stamp};
use loc_core::Pose2;

/// The frame of the robot, and where it is in the one that the odometry is about: the frame that
/// is asked for, where fixed transforms join the two.
pub(super) fn base(
    names: &RosNames,
    preview: &Preview,
    odometry: &OdometryFrom,
    child: &str,
    notes: &mut Vec<String>,
) -> (String, Pose2) {
    let same = (child.to_owned(), Pose2::IDENTITY);
    let Some(asked) = names.base_frame.as_deref().map(plain).filter(|name| *name != child) else {
        return same;
    };
    // A transform is the odometry of its own child.
    let is_topic = matches!(odometry, OdometryFrom::Topic(_));
    match preview.frames.lookup(child, asked, Stamp(0), 0.0) {
        Ok(place) if is_topic => (asked.to_owned(), messages::planar(&place)),
        _ => {
            notes.push(missing("base_frame_id", asked, child));
            same
        }
    }
}

/// Notes what else is asked for and not there.
pub(super) fn check(
    names: &RosNames,
    preview: &Preview,
    odometry: &OdometryFrom,
    notes: &mut Vec<String>,
) {
    let odom = match odometry {
        OdometryFrom::Transform(frame) => Some(frame.as_str()),
        OdometryFrom::Topic(topic) => preview.odometry_frames.get(topic).map(|of| of.0.as_str()),
    };
    let asked = names.odom_frame.as_deref().map(plain);
    if let Some((asked, odom)) = asked.zip(odom).filter(|(asked, odom)| *asked != plain(odom)) {
        notes.push(missing("odom_frame_id", asked, plain(odom)));
    }
    let has = |name: &str| preview.moving_below(|frame| frame == name).is_some();
    let asked = names.map_frame.as_deref().map(plain);
    if let Some(asked) = asked.filter(|asked| has("map") && !has(asked)) {
        notes.push(missing("global_frame_id", asked, "map"));
    }
}

/// A line for the user.
pub(super) fn missing(key: &str, name: &str, taken: &str) -> String {
    format!("{key} {name}: not in the bag, {taken} taken")
}
