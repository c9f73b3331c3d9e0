//! Beams that are shorter than the map lets expect.

use super::{BeliefSample, Kept, without};
use crate::Result;
use crate::mcl::MountedScan;
use crate::sensor::beam::reading;
use loc_core::Normal;
use loc_core::error::{positive, probability};
use loc_maps::RayCaster;

/// Drops a beam that is, averaged over the belief, shorter than expected with more than a given
/// probability (K3): something that is on no map stands in its way.
///
/// A beam of range d is shorter than expected with `P(d < d* + e)`, e of `N(0, sigma_hit^2)`,
/// where the map lets expect d*; with 1 where it lets expect nothing. Beams without a return are
/// never dropped. What keeps it from throwing away what is needed:
///
/// * with a wide belief (global localization) a beam is dropped only where it is too short nearly
///   everywhere the robot may be;
/// * where more than `max_dropped` of the beams are too short, the belief is wrong rather than
///   the room full, and all are kept;
/// * beams that are too long are kept always, and tell a robot at a wrong place that it is lost;
/// * in a room as mapped a beam has to be too short by 2.3 `sigma_hit` at all poses, which noise
///   and a cloud off by less hardly do.
///
/// A few rays are cast for a beam that is kept, one for each pose of the sample for a dropped one.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct DistanceFilter {
    /// The probability from which on a beam is dropped.
    pub threshold: f64,
    /// Standard deviation of what measures the obstacle of the map \[m\].
    pub sigma_hit: f64,
    /// The largest share of the beams that is dropped.
    pub max_dropped: f64,
}

impl Default for DistanceFilter {
    fn default() -> Self {
        DistanceFilter { threshold: 0.99, sigma_hit: 0.2, max_dropped: 0.8 }
    }
}

impl DistanceFilter {
    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] naming the first that is not allowed.
    pub fn validate(&self) -> Result<()> {
        probability("threshold of the distance filter", self.threshold)?;
        positive("sigma_hit of the distance filter [m]", self.sigma_hit)?;
        probability("largest share that the distance filter drops", self.max_dropped)?;
        Ok(())
    }

    /// Which of the beams numbered `beams` to keep. Without a sample, all of them.
    ///
    /// # Errors
    /// Those of [`validate`](Self::validate).
    pub fn keep(
        &self,
        caster: &RayCaster,
        sample: &BeliefSample,
        mounted: &MountedScan<'_>,
        beams: &[usize],
    ) -> Result<Kept> {
        self.validate()?;
        let mut suspects = suspects(mounted, beams);
        let frame = caster.frame();
        // Pose by pose: the first one clears most beams.
        for (pose, weight) in sample.poses().iter().zip(sample.weights()) {
            let laser = *pose * mounted.mounting;
            let (sin, cos) = laser.theta.sin_cos();
            let (start, [cos, sin]) =
                (frame.to_cells(&laser.position()), frame.turn_to_grid([cos, sin]));
            suspects.retain_mut(|suspect| {
                let [x, y] = suspect.direction;
                let along = [cos * x - sin * y, sin * x + cos * y];
                let far = (suspect.range + FAR * self.sigma_hit) / frame.resolution();
                let length = caster.cast_in_cells([start.x, start.y], along, far);
                let expected = length.map(|length| length * frame.resolution());
                suspect.not_short += weight * self.not_short(expected, suspect.range);
                suspect.not_short < 1.0 - self.threshold
            });
        }
        let mut is_novel = vec![false; beams.len()];
        if !sample.poses().is_empty() {
            suspects.iter().for_each(|suspect| is_novel[suspect.index] = true);
        }
        Ok(without(beams, &is_novel, self.max_dropped))
    }

    /// The probability that a range is not shorter than the expected one, `None` for one that is
    /// farther away than matters.
    fn not_short(&self, expected: Option<f64>, range: f64) -> f64 {
        let deviation = |expected| (range - expected) / self.sigma_hit;
        expected.map_or(0.0, |expected| Normal::STANDARD.cdf(deviation(expected)))
    }
}

/// Where the obstacle is this much farther away than the beam says, it does not matter how far
/// \[sigma_hit\].
const FAR: f64 = 8.0;

/// A beam that no pose has explained so far.
struct Suspect {
    /// Its place in the list of beams.
    index: usize,
    /// Its direction in the laser's frame, a unit vector.
    direction: [f64; 2],
    range: f64,
    /// The probability so far that it is not too short.
    not_short: f64,
}

/// The beams that returned from somewhere.
fn suspects(mounted: &MountedScan<'_>, beams: &[usize]) -> Vec<Suspect> {
    let scan = mounted.scan;
    let suspect = |(index, &beam): (usize, &usize)| {
        let range = reading(scan, beam, scan.range_max).filter(|range| range.is_finite())?;
        let (sin, cos) = scan.angle(beam).sin_cos();
        Some(Suspect { index, direction: [cos, sin], range, not_short: 0.0 })
    };
    beams.iter().enumerate().filter_map(suspect).collect()
}
