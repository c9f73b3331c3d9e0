//! Where the robot of a recording starts.

use super::{Entry, LaserLog, ReplayOptions, unsuitable};
use crate::Result;
use loc_core::Pose2;
use loc_maps::OccupancyGrid;
use loc_maps::grid::Occupancy;

/// Where the robot starts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Start {
    /// Where the reference says.
    #[default]
    Reference,
    /// At this pose in the map, with the first scan that is used.
    At(Pose2),
    /// Methods that search the whole map are not told; others start where the reference says or,
    /// without one, at the pose of the odometry.
    Anywhere,
}

/// The pose at the first scan, and whether anybody knows it.
pub(in crate::source) fn start_pose(
    log: &mut LaserLog,
    options: &ReplayOptions,
) -> Result<(Pose2, bool)> {
    let first = log.entries.iter().position(Entry::is_scan).unwrap_or(0);
    let odometry = log.entries.get(first).and_then(Entry::odometry).unwrap_or_default();
    let (pose, known) = match (options.start, by_reference(&log.entries, first)) {
        (Start::At(pose), _) if !pose.is_finite() => {
            return Err(unsuitable(log, "a finite start pose", pose.to_string()));
        }
        (Start::At(pose), _) => (pose, true),
        (_, Some(map_from_odom)) => (map_from_odom * odometry, true),
        (Start::Anywhere, None) => (odometry, false),
        (Start::Reference, None) => {
            let expected = "a reference to start from, a start pose (--initial-pose x,y,yaw) or a \
                            search for it (--global)";
            return Err(unsuitable(log, expected, "none of them"));
        }
    };
    if let Some(map) = options.map.as_deref().filter(|_| known) {
        check_place(log, pose, map)?;
    }
    Ok((pose, known))
}

/// The place of the odometry's frame in the map, by the last true pose up to the first scan, or
/// else the first one after it.
fn by_reference(entries: &[Entry], first: usize) -> Option<Pose2> {
    let is_true = |entry: &Entry| entry.truth().is_some();
    let until = entries.get(..=first).unwrap_or_default();
    let place = until.iter().rposition(is_true).or_else(|| entries.iter().position(is_true))?;
    let before = entries[..=place].iter().rev().find_map(Entry::odometry);
    let odometry = before.or_else(|| entries[place..].iter().find_map(Entry::odometry))?;
    Some(entries[place].truth()? * odometry.inverse())
}

fn check_place(log: &mut LaserLog, pose: Pose2, map: &OccupancyGrid) -> Result<()> {
    if map.frame().cell_at(&pose.position()).is_none() {
        return Err(unsuitable(log, "a start pose inside the map", pose.to_string()));
    }
    let kind = match map.occupancy_at(&pose.position()) {
        Occupancy::Free => return Ok(()),
        Occupancy::Occupied => "an occupied",
        Occupancy::Unknown => "an unknown",
    };
    log.notes.push(format!("the start pose {pose} lies in {kind} cell of the map"));
    Ok(())
}
