//! Beams that would make the robot less sure.

use super::{BeliefSample, Kept, without};
use crate::Result;
use crate::mcl::MountedScan;
use crate::sensor::beam::reading;
use loc_core::error::{non_negative, probability};
use nalgebra::Point2;

/// Drops a beam after which the belief would be less certain than before (K3): its entropy
/// `H = -integral b ln b` rises.
///
/// A beam that fits the belief sharpens it. One that hits a person moves weight to the edge of the
/// belief, or to places that were all but ruled out. So does a beam that rightly tells the robot
/// that it is somewhere else: with this filter alone a kidnapped robot stays lost. Where more than
/// `max_dropped` of the beams raise the entropy, all are kept.
///
/// Of the density before the beam, the Gaussian with the sample's mean and covariance is taken;
/// what the beam makes of it is counted over the sample, whatever its shape.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct EntropyFilter {
    /// A rise up to this is let through \[nat\]: with a few poses the entropies are uncertain.
    pub tolerance: f64,
    /// The largest share of the beams that is dropped.
    pub max_dropped: f64,
}

impl Default for EntropyFilter {
    fn default() -> Self {
        EntropyFilter { tolerance: 0.01, max_dropped: 0.8 }
    }
}

impl EntropyFilter {
    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] naming the first that is not allowed.
    pub fn validate(&self) -> Result<()> {
        non_negative("tolerance of the entropy filter [nat]", self.tolerance)?;
        probability("largest share that the entropy filter drops", self.max_dropped)?;
        Ok(())
    }

    /// Which of the beams numbered `beams` to keep, those that say nothing included. `rating` is
    /// the logarithm of the likelihood of a beam, as [`by_field`](super::by_field) or
    /// [`by_casting`](super::by_casting) give it.
    ///
    /// # Errors
    /// Those of [`validate`](Self::validate).
    pub fn keep(
        &self,
        rating: impl Fn(Point2<f64>, [f64; 2], f64) -> f64,
        sample: &BeliefSample,
        mounted: &MountedScan<'_>,
        beams: &[usize],
    ) -> Result<Kept> {
        self.validate()?;
        let mounting = mounted.mounting;
        let lasers: Vec<(Point2<f64>, [f64; 2])> = sample
            .poses()
            .iter()
            .map(|pose| {
                let laser = *pose * mounting;
                let (sin, cos) = laser.theta.sin_cos();
                (laser.position(), [cos, sin])
            })
            .collect();
        let prior = sample.log_densities();
        let mut ratings = vec![0.0; lasers.len()];
        let mut raises = |beam: usize| {
            let max_range = mounted.scan.range_max;
            let Some(range) = reading(mounted.scan, beam, max_range) else { return false };
            let (y, x) = mounted.scan.angle(beam).sin_cos();
            for (rated, (laser, [cos, sin])) in ratings.iter_mut().zip(&lasers) {
                *rated = rating(*laser, [cos * x - sin * y, sin * x + cos * y], range);
            }
            change(&prior, sample.weights(), &ratings) > self.tolerance
        };
        let is_novel: Vec<bool> = beams.iter().map(|&beam| raises(beam)).collect();
        Ok(without(beams, &is_novel, self.max_dropped))
    }
}

/// How much the entropy of a belief b rises by a measurement of likelihood p. After it the belief
/// is `b p / Z`, so that its entropy is the mean of `ln Z - ln b - ln p` over the new weights
/// `w p / Z`; before, that of `-ln b` over w.
// ANCHOR: entropy
fn change(prior: &[f64], weights: &[f64], ratings: &[f64]) -> f64 {
    let largest = ratings.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !largest.is_finite() {
        return 0.0;
    }
    let (mut total, mut before, mut after) = (0.0, 0.0, 0.0);
    for ((log_density, weight), rating) in prior.iter().zip(weights).zip(ratings) {
        let rating = rating - largest;
        let new = weight * rating.exp();
        total += new;
        before -= weight * log_density;
        // A weight of 0 counts for nothing, even with a rating of -inf.
        after -= if new > 0.0 { new * (log_density + rating) } else { 0.0 };
    }
    after / total + total.ln() - before
}
// ANCHOR_END: entropy
