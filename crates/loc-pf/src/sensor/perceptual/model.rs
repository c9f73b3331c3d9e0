//! The conditional density that the counts say.

use super::PerceptualHistogram;
use crate::sensor::beam::RangeModel;

/// Pairs that are added to those of every expected range, spread evenly over all that can be
/// measured: what was never seen stays possible.
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
    pub(super) fn new(histogram: &PerceptualHistogram) -> Self {
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
