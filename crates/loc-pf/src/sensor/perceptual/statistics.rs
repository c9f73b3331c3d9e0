//! Counts of range pairs, and the maximum likelihood fit of the beam model by expectation
//! maximization.

use super::{PerceptualModel, RangePair};
use crate::Result;
use crate::sensor::beam::{BeamForm, BeamModel, BeamModelSettings};
use loc_core::Normal;
use loc_core::error::{in_range, positive};

/// Sums over all pairs, each part weighted by its responsibility for the pair (expectation step).
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
/// Below this an exponential distribution is indistinguishable from a uniform one [1/m].
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

/// Maximum number of bins along an axis.
const MAX_BINS: f64 = 4096.0;

/// Counts of pairs of expected and measured range.
///
/// Both axes have bins of the same width from 0 to the longest range, and one more for no return.
/// Four bytes for each pair of bins.
#[derive(Debug, Clone, PartialEq)]
pub struct PerceptualHistogram {
    max_range: f64,
    bins: usize,
    /// Rows of the same expected range.
    counts: Vec<u32>,
    pairs: u64,
}

impl PerceptualHistogram {
    /// An empty histogram up to `max_range` \[m\], with bins about `width` \[m\] wide: as many as
    /// fit evenly.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for lengths that are not above 0, and for more than 4096
    /// bins.
    pub fn new(max_range: f64, width: f64) -> Result<Self> {
        positive("max_range [m]", max_range)?;
        positive("width of a bin [m]", width)?;
        let bins = (max_range / width).round().max(1.0);
        in_range("bins of a histogram", "at most 4096", bins, |bins| bins <= MAX_BINS)?;
        let bins = bins as usize;
        let counts = vec![0; (bins + 1) * (bins + 1)];
        Ok(PerceptualHistogram { max_range, bins, counts, pairs: 0 })
    }

    /// Counts a pair; one that is not two ranges (NaN, negative) is left out.
    pub fn add(&mut self, pair: RangePair) {
        let (Some(row), Some(column)) = (self.bin(pair.expected), self.bin(pair.measured)) else {
            return;
        };
        let count = &mut self.counts[row * (self.bins + 1) + column];
        *count = count.saturating_add(1);
        self.pairs += 1;
    }

    /// Number of pairs that were counted.
    pub fn pairs(&self) -> u64 {
        self.pairs
    }

    /// Ranges from here on count as no return \[m\].
    pub fn max_range(&self) -> f64 {
        self.max_range
    }

    /// Number of bins up to the longest range, without the one for no return.
    pub fn bins(&self) -> usize {
        self.bins
    }

    /// Width of a bin \[m\].
    pub fn width(&self) -> f64 {
        self.max_range / self.bins as f64
    }

    /// The bin of a range; [`bins`](Self::bins) for no return, `None` for what is no range.
    pub fn bin(&self, range: f64) -> Option<usize> {
        // The cast saturates.
        (range >= 0.0).then(|| ((range / self.width()) as usize).min(self.bins))
    }

    /// Counts of the measured bins where the expected range lies in bin `expected`, the last one
    /// for no return; empty where there is no such bin.
    pub fn row(&self, expected: usize) -> &[u32] {
        let columns = self.bins + 1;
        self.counts.get(expected * columns..(expected + 1) * columns).unwrap_or_default()
    }

    /// The conditional density `p(measured | expected)`.
    pub fn model(&self) -> PerceptualModel {
        PerceptualModel::new(self)
    }
}

/// Minimum number of pairs with both ranges in reach, for six parameters.
const MIN_PAIRS: usize = 100;

/// Maximum number of steps.
const MAX_STEPS: usize = 500;

/// The fit has converged when a step gains less than this a pair.
const GAIN: f64 = 1e-7;

/// Maximum number of halvings of a step that lowers the likelihood.
const HALVINGS: usize = 30;

/// A share of 0 would stay 0.
const MIN_SHARE: f64 = 0.01;

/// The result of the fit.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FitReport {
    /// The parameters found; shares add up to 1.
    pub settings: BeamModelSettings,
    /// The mean of `ln p(measured | expected)` over the pairs, at the start and after every step;
    /// it never falls.
    pub log_likelihoods: Vec<f64>,
    /// Number of pairs that were used.
    pub pairs: usize,
    /// Whether the fit converged; if not, it stopped at the maximum number of steps.
    pub converged: bool,
}

/// The parameters of the beam model that make the pairs most likely, found by expectation
/// maximization from `start` (K2; Probabilistic Robotics, table 6.2, with exact normalisers).
///
/// `start` also gives the longest range; the form of the model is always the mixture. Shares below
/// 0.01 start from there. `sigma_hit` does not go below 1 mm, nor `lambda_short` below 1e-4 / m.
///
/// # Errors
/// [`loc_core::Error::Length`] for fewer than 100 pairs with both ranges in reach; pairs that are
/// not two ranges (NaN, negative) do not count. Those of [`BeamModelSettings::check`].
pub fn fit_beam_model(pairs: &[RangePair], start: &BeamModelSettings) -> Result<FitReport> {
    let mut settings = start.normalized()?;
    let z = [&mut settings.z_hit, &mut settings.z_short, &mut settings.z_max, &mut settings.z_rand];
    z.into_iter().for_each(|share| *share = share.max(MIN_SHARE));
    settings.form = BeamForm::Mixture;
    let ranges = |pair: &&RangePair| pair.expected >= 0.0 && pair.measured >= 0.0;
    let pairs: Vec<RangePair> = pairs.iter().filter(ranges).copied().collect();
    let in_reach = |pair: &&RangePair| pair.expected.max(pair.measured) < settings.max_range;
    let found = pairs.iter().filter(in_reach).count();
    if found < MIN_PAIRS {
        let what = "pairs of an expected and a measured range within reach";
        return Err(loc_core::Error::Length { what, expected: "at least 100", found }.into());
    }
    climb(&pairs, settings.normalized()?)
}

/// Steps until convergence.
// ANCHOR: climb
fn climb(pairs: &[RangePair], mut settings: BeamModelSettings) -> Result<FitReport> {
    let mean = |statistics: &Statistics| statistics.log_likelihood / pairs.len() as f64;
    let mut now = Statistics::of(pairs, &BeamModel::new(&settings)?);
    let mut log_likelihoods = vec![mean(&now)];
    let mut converged = false;
    while !converged && log_likelihoods.len() <= MAX_STEPS {
        let mut proposed = now.improve(&settings);
        let mut next = Statistics::of(pairs, &BeamModel::new(&proposed)?);
        for _ in 0..HALVINGS {
            // NaN counts as lower.
            if next.log_likelihood >= now.log_likelihood {
                break;
            }
            proposed = between(&settings, &proposed);
            next = Statistics::of(pairs, &BeamModel::new(&proposed)?);
        }
        let gain = mean(&next) - mean(&now);
        converged = gain.is_nan() || gain < GAIN;
        if gain >= 0.0 {
            (settings, now) = (proposed, next);
            log_likelihoods.push(mean(&now));
        }
    }
    Ok(FitReport { settings, log_likelihoods, pairs: pairs.len(), converged })
}
// ANCHOR_END: climb

/// The midpoint of two sets of parameters.
fn between(a: &BeamModelSettings, b: &BeamModelSettings) -> BeamModelSettings {
    BeamModelSettings {
        form: a.form,
        max_range: a.max_range,
        z_hit: 0.5 * (a.z_hit + b.z_hit),
        z_short: 0.5 * (a.z_short + b.z_short),
        z_max: 0.5 * (a.z_max + b.z_max),
        z_rand: 0.5 * (a.z_rand + b.z_rand),
        sigma_hit: (a.sigma_hit * b.sigma_hit).sqrt(),
        lambda_short: (a.lambda_short * b.lambda_short).sqrt(),
    }
}
