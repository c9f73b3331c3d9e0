//! Expected and measured ranges that belong together.

use crate::sensor::beam::reading;
use loc_core::Pose2;
use loc_sensors::laser::LaserScan;
use loc_sensors::world::RangeWorld;

/// The range that a map lets expect and the one that was measured \[m\]; +inf for no return.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangePair {
    /// By casting the beam in the map.
    pub expected: f64,
    /// By the range finder.
    pub measured: f64,
}

/// The pairs of a scan taken from a known pose of the laser, for its beams that say something.
/// Ranges from `max_range` \[m\] on, or that of the scan if shorter, count as no return.
pub fn range_pairs(
    world: &impl RangeWorld,
    laser: Pose2,
    scan: &LaserScan,
    max_range: f64,
) -> Vec<RangePair> {
    let mut expected = vec![f64::INFINITY; scan.ranges.len()];
    let first = laser.theta + scan.angle_min;
    let max_range = max_range.min(scan.range_max);
    world.cast_fan(&laser.position(), first, scan.angle_increment, max_range, &mut expected);
    let beams = expected.into_iter().enumerate();
    let pair = |(beam, expected): (usize, f64)| {
        let expected = if expected < max_range { expected } else { f64::INFINITY };
        Some(RangePair { expected, measured: reading(scan, beam, max_range)? })
    };
    beams.filter_map(pair).collect()
}
