//! The perceptual model learned from data: the distribution of measured ranges given the range
//! expected by the map (K2).
//!
//! Every beam taken at a known pose is a [`RangePair`]: the range expected by the map there, and
//! the one that was measured. Counted over both, many pairs give the surface
//! `p(measured | expected)`: a ridge along `measured = expected`, a slope before it from people and chairs that
//! are not in the map, a peak at the longest range. [`PerceptualHistogram`] keeps the counts; its
//! [`PerceptualModel`] rates scans directly. [`fit_beam_model`] finds the parameters of the
//! [`BeamModel`](super::BeamModel) that explain the pairs best, by maximum likelihood.
//!
//! ```
//! use loc_core::random::stream;
//! use loc_pf::sensor::BeamModelSettings;
//! use loc_pf::sensor::perceptual::{PerceptualHistogram, RangePair, fit_beam_model};
//! use rand::RngExt;
//! let mut rng = stream(1, "laser");
//! // 5 % of the beams see nothing, the others are 3 cm off.
//! let pairs: Vec<RangePair> = (0..2000).map(|_| {
//!     let expected = rng.random_range(1.0..8.0);
//!     let off = 0.05 * rng.random_range(-1.0..1.0_f64);
//!     let measured = if rng.random_bool(0.05) { f64::INFINITY } else { expected + off };
//!     RangePair { expected, measured }
//! }).collect();
//! let start = BeamModelSettings::default().max_range(10.0);
//! let fit = fit_beam_model(&pairs, &start)?;
//! assert!(fit.converged && (fit.settings.z_max - 0.05).abs() < 0.02);
//! assert!((fit.settings.sigma_hit - 0.05 / 3_f64.sqrt()).abs() < 0.002);
//!
//! let mut histogram = PerceptualHistogram::new(10.0, 0.1)?;
//! pairs.iter().for_each(|&pair| histogram.add(pair));
//! let model = histogram.model();
//! assert!(model.density(5.0, 5.0) > 100.0 * model.density(5.0, 3.0));
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod statistics;

pub use statistics::{FitReport, PerceptualHistogram, fit_beam_model};

use super::beam::{RangeModel, reading};
use loc_core::Pose2;
use loc_sensors::laser::LaserScan;
use loc_sensors::world::RangeWorld;

/// The range expected by a map and the measured one \[m\]; +inf for no return.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangePair {
    /// By casting the beam in the map.
    pub expected: f64,
    /// By the range finder.
    pub measured: f64,
}

/// The pairs of a scan taken from a known pose of the laser, for its informative beams.
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

/// Pairs that are added to those of every expected range, spread evenly over all that can be
/// measured: ranges without counts stay possible.
const ADDED: f64 = 10.0;

/// Weights of a row itself and of its neighbours on either side.
const KERNEL: [f64; 3] = [1.0, 2.0 / 3.0, 1.0 / 3.0];

/// `p(measured | expected)` as counted (K2), usable as the model of a
/// [`BeamLikelihood`](crate::sensor::BeamLikelihood).
///
/// Neighbouring expected ranges share their counts by how far the measured range is off, so that
/// the ridge along `measured = expected` stays as narrow as it is: two rows on either side, with
/// weights that fall off linearly. Between the middles of bins the density is interpolated, again
/// along the ridge. Single precision.
#[derive(Debug, Clone, PartialEq)]
pub struct PerceptualModel {
    max_range: f64,
    bins: usize,
    /// Rows of the same expected range: densities \[1/m\], the last one a probability.
    densities: Vec<f32>,
}

impl PerceptualModel {
    fn new(histogram: &PerceptualHistogram) -> Self {
        let (bins, width) = (histogram.bins(), histogram.width());
        let mut densities = Vec::with_capacity((bins + 1) * (bins + 1));
        for expected in 0..=bins {
            let mut row = shared(histogram, expected);
            let total: f64 = row.iter().sum::<f64>() + ADDED;
            let each = ADDED / (bins + 1) as f64;
            row.iter_mut().for_each(|count| *count = (*count + each) / total);
            let finite = row.iter().take(bins).map(|share| (share / width) as f32);
            densities.extend(finite);
            densities.extend(row.last().map(|share| *share as f32));
        }
        PerceptualModel { max_range: histogram.max_range(), bins, densities }
    }

    /// Width of a bin \[m\].
    pub fn width(&self) -> f64 {
        self.max_range / self.bins as f64
    }

    /// `p(measured | expected)`: a density \[1/m\] for a finite `measured`, the probability of no
    /// return for +inf. NaN counts as no return.
    pub fn density(&self, expected: f64, measured: f64) -> f64 {
        let (width, last) = (self.width(), self.bins - 1);
        // Written so that NaN is no return.
        let in_reach = |range: f64| range < self.max_range;
        if !in_reach(expected) {
            return if in_reach(measured) {
                self.along(self.bins, measured)
            } else {
                self.at(self.bins, self.bins)
            };
        }
        let place = (expected / width - 0.5).clamp(0.0, last as f64);
        let lower = place as usize;
        let upper = (lower + 1).min(last);
        let share = place - lower as f64;
        let of = |row: usize| {
            if !in_reach(measured) {
                return self.at(row, self.bins);
            }
            self.along(row, measured + (row as f64 + 0.5) * width - expected.max(0.0))
        };
        (1.0 - share) * of(lower) + share * of(upper)
    }

    /// The density in a row, interpolated between the middles of its bins.
    fn along(&self, row: usize, measured: f64) -> f64 {
        let last = self.bins - 1;
        let place = (measured / self.width() - 0.5).clamp(0.0, last as f64);
        let lower = place as usize;
        let share = place - lower as f64;
        (1.0 - share) * self.at(row, lower) + share * self.at(row, (lower + 1).min(last))
    }

    fn at(&self, row: usize, column: usize) -> f64 {
        f64::from(self.densities[row * (self.bins + 1) + column])
    }
}

/// The counts of a row with those of its neighbours, shifted along the ridge.
fn shared(histogram: &PerceptualHistogram, expected: usize) -> Vec<f64> {
    let bins = histogram.bins();
    let mut sum = vec![0.0; bins + 1];
    if expected == bins {
        let row = histogram.row(bins).iter();
        return row.map(|count| f64::from(*count)).collect();
    }
    let reach = KERNEL.len() - 1;
    for row in expected.saturating_sub(reach)..=(expected + reach).min(bins - 1) {
        let weight = KERNEL[row.abs_diff(expected)];
        for (column, &count) in histogram.row(row).iter().enumerate() {
            let shifted = (column + expected).saturating_sub(row).min(bins - 1);
            let target = if column == bins { bins } else { shifted };
            sum[target] += weight * f64::from(count);
        }
    }
    sum
}

impl RangeModel for PerceptualModel {
    fn max_range(&self) -> f64 {
        self.max_range
    }

    fn step(&self) -> f64 {
        self.width() / 4.0
    }

    fn log_density(&self, expected: f64, measured: f64) -> f64 {
        self.density(expected, measured).max(f64::from(f32::MIN_POSITIVE)).ln()
    }
}
