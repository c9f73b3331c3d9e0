//! What the pairs say about parameters that are nearly right: one pass of expectation.

use super::RangePair;
use crate::sensor::beam::{BeamModel, BeamModelSettings};
use loc_core::Normal;

/// Sums over all pairs, each part weighted by how likely it explains the pair.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Statistics {
    /// Sum of the logarithms of the densities.
    pub(super) log_likelihood: f64,
    /// Pairs that hit, short, max and random explain.
    parts: [f64; 4],
    /// Hits: squared deviations, and what they are expected to be [sigma_hit^2].
    squares: f64,
    expected_squares: f64,
    /// Short ones: ranges, and their mean and variance under the current lambda_short.
    shorts: f64,
    expected_shorts: f64,
    variance_of_shorts: f64,
}

impl Statistics {
    /// Explains every pair by the model.
    pub(super) fn of(pairs: &[RangePair], model: &BeamModel) -> Self {
        let mut sums = Statistics::default();
        let BeamModelSettings { max_range, lambda_short, .. } = *model.settings();
        for &RangePair { expected, measured } in pairs {
            let parts = model.parts(expected, measured);
            let total: f64 = parts.iter().sum();
            sums.log_likelihood += total.ln();
            let shares = parts.map(|part| part / total);
            for (sum, share) in sums.parts.iter_mut().zip(shares) {
                *sum += share;
            }
            let [hit, short, ..] = shares;
            if hit > 0.0 && measured < max_range {
                sums.squares += hit * (measured - expected).powi(2);
                sums.expected_squares += hit * squared_deviation(expected, model.settings());
            }
            if short > 0.0 {
                let (mean, variance) = truncated(lambda_short, expected.min(max_range));
                sums.shorts += short * measured;
                sums.expected_shorts += short * mean;
                sums.variance_of_shorts += short * variance;
            }
        }
        sums
    }

    /// Better parameters: shares as the pairs are explained, and for `sigma_hit` and `lambda_short`
    /// a step towards where the likelihood of their part is largest. Both parts are normalised on
    /// a part of the axis, which the plain mean of the squares and the plain inverse of the mean
    /// (table 6.2 of Probabilistic Robotics) do not know of.
    pub(super) fn improve(&self, settings: &BeamModelSettings) -> BeamModelSettings {
        let total: f64 = self.parts.iter().sum();
        let [z_hit, z_short, z_max, z_rand] = self.parts.map(|part| part / total);
        let mut better = BeamModelSettings { z_hit, z_short, z_max, z_rand, ..*settings };
        if self.expected_squares > 0.0 {
            let sigma = (self.squares / self.expected_squares).sqrt();
            better.sigma_hit = sigma.clamp(MIN_SIGMA, settings.max_range);
        }
        if self.variance_of_shorts > 0.0 {
            let lambda = settings.lambda_short;
            let step = (self.expected_shorts - self.shorts) / self.variance_of_shorts;
            let newton = (lambda + step).clamp(lambda / 3.0, lambda * 3.0);
            better.lambda_short = newton.clamp(MIN_LAMBDA, MAX_LAMBDA);
        }
        better
    }
}

/// Simulated ranges without noise would end at 0.
const MIN_SIGMA: f64 = 1e-3;
/// From here on there is no telling an even distribution from one that falls off [1/m].
const MIN_LAMBDA: f64 = 1e-4;
const MAX_LAMBDA: f64 = 1e3;

/// The expected square of a hit's deviation in units of sigma^2: below 1 near the ends.
fn squared_deviation(expected: f64, settings: &BeamModelSettings) -> f64 {
    let sigma = settings.sigma_hit;
    let (a, b) = (-expected / sigma, (settings.max_range - expected) / sigma);
    if a < -8.0 && b > 8.0 {
        return 1.0;
    }
    let bell = Normal::STANDARD;
    let inside = bell.probability(a, b);
    1.0 - (b * bell.density(b) - a * bell.density(a)) / inside
}

/// Mean and variance of the exponential distribution cut off at `end`.
fn truncated(lambda: f64, end: f64) -> (f64, f64) {
    let x = lambda * end;
    if x < 1e-2 {
        // The first terms of their series; what is left out is below 1e-6 of them.
        return (end * (0.5 - x / 12.0), end * end / 12.0);
    }
    // 1 / (e^x - 1), 0 for large x.
    let tail = 1.0 / x.exp_m1();
    let mean = 1.0 / lambda - end * tail;
    (mean, 1.0 / (lambda * lambda) - end * end * tail * (1.0 + tail))
}
