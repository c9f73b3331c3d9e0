//! Sampling from distributions by way of uniform random numbers (F4).
//!
//! A generator draws uniformly from the interval (0, 1). Taken as a value of the cumulative
//! distribution function of another distribution, such a number maps to a draw from it:
//! [`inverse_cdf`] does so for a continuous distribution, [`CumulativeTable`] for a list of
//! weights. For the normal distribution, whose cumulative distribution has no closed inverse, there
//! is the exact [`box_muller`] and two fast approximations. [`Uniform`] is the continuous uniform
//! distribution.
//!
//! ```
//! use loc_core::{random, sampling};
//! let mut rng = random::stream(1, "waiting times");
//! let exponential = |p: f64| -(1.0 - p).ln();
//! let mean = (0..10_000).map(|_| sampling::inverse_cdf(exponential, &mut rng)).sum::<f64>() / 1e4;
//! assert!((mean - 1.0).abs() < 0.05);
//! ```

use crate::Result;
use crate::error::{finite, in_range, non_negative, positive, probability};
use rand::distr::Open01;
use rand::{Rng, RngExt};
use std::f64::consts::TAU;

/// A draw from the distribution whose quantile function (inverse cumulative distribution) is
/// `quantile`; that function is evaluated at one number from the open interval (0, 1).
pub fn inverse_cdf<T, R: Rng + ?Sized>(quantile: impl FnOnce(f64) -> T, rng: &mut R) -> T {
    quantile(rng.sample(Open01))
}

/// Two independent draws from the standard normal distribution, by the method of Box and Muller
/// (1958): exact, at the cost of a logarithm, a root, a sine and a cosine.
// ANCHOR: box-muller
pub fn box_muller<R: Rng + ?Sized>(rng: &mut R) -> (f64, f64) {
    let (u1, u2): (f64, f64) = (rng.sample(Open01), rng.sample(Open01));
    let radius = (-2.0 * u1.ln()).sqrt();
    let (sin, cos) = (TAU * u2).sin_cos();
    (radius * cos, radius * sin)
}
// ANCHOR_END: box-muller

/// Nearly a normal draw with mean 0 and standard deviation `sigma`, by the twelve rule
/// `1/2 sum_12 U(-b, b)`; the literature calls `sigma` b.
///
/// Mean and variance are exact. The kurtosis is 2.9 instead of 3, and no draw lies beyond
/// 6 `sigma`.
pub fn twelve_rule<R: Rng + ?Sized>(sigma: f64, rng: &mut R) -> f64 {
    0.5 * (0..12).map(|_| symmetric(sigma, rng)).sum::<f64>()
}

/// A draw from the symmetric triangle with mean 0 and standard deviation `sigma`,
/// `sqrt(6)/2 [U(-b, b) + U(-b, b)]`; the literature calls `sigma` b.
///
/// A coarser approximation of the normal distribution: the kurtosis is 2.4, and no draw lies beyond
/// `sqrt(6) sigma`.
pub fn triangular<R: Rng + ?Sized>(sigma: f64, rng: &mut R) -> f64 {
    0.5 * 6_f64.sqrt() * (symmetric(sigma, rng) + symmetric(sigma, rng))
}

/// U(-b, b).
fn symmetric<R: Rng + ?Sized>(b: f64, rng: &mut R) -> f64 {
    b * (2.0 * rng.random::<f64>() - 1.0)
}

/// Running sums of a list of weights: draws an index in proportion to its weight by binary search.
#[derive(Debug, Clone, PartialEq)]
pub struct CumulativeTable {
    sums: Vec<f64>,
    total: f64,
    /// The last index whose weight is not 0, where rounding may lead at the upper end.
    last: usize,
}

impl CumulativeTable {
    /// The table of `weights`, which need not sum to 1.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a weight that is negative or not finite, and where the sum
    /// is 0 (no weights included) or overflows.
    pub fn new(weights: impl IntoIterator<Item = f64>) -> Result<Self> {
        let weights: Vec<f64> = weights.into_iter().collect();
        for &weight in &weights {
            non_negative("weight", weight)?;
        }
        let table = CumulativeTable::from_checked(&weights);
        positive("sum of the weights", table.total)?;
        Ok(table)
    }

    /// The table of weights that are known to be finite, >= 0, and not all 0.
    pub(crate) fn from_checked(weights: &[f64]) -> Self {
        let running_sum = |sum: &mut f64, &weight: &f64| {
            *sum += weight;
            Some(*sum)
        };
        let sums: Vec<f64> = weights.iter().scan(0.0, running_sum).collect();
        CumulativeTable {
            total: sums.last().copied().unwrap_or(0.0),
            last: weights.iter().rposition(|&w| w > 0.0).unwrap_or(0),
            sums,
        }
    }

    /// Sum of all weights.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// The index that the height `p` of the cumulative distribution leads to; never one whose
    /// weight is 0.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a `p` outside \[0, 1\].
    pub fn index_at(&self, p: f64) -> Result<usize> {
        Ok(self.lookup(probability("height of the cumulative distribution", p)?))
    }

    /// Draws an index in O(log n).
    pub fn sample<R: Rng + ?Sized>(&self, rng: &mut R) -> usize {
        inverse_cdf(|p| self.lookup(p), rng)
    }

    fn lookup(&self, p: f64) -> usize {
        let height = p * self.total;
        self.sums.partition_point(|&sum| sum <= height).min(self.last)
    }
}

/// U\[low, high\]: every number of an interval is equally likely.
///
/// ```
/// use loc_core::probability::Uniform;
/// let temperature = Uniform::new(18.0, 26.0)?;
/// assert!((temperature.probability(20.0, 22.0) - 0.25).abs() < 1e-12);
/// # Ok::<(), loc_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uniform {
    low: f64,
    high: f64,
}

impl Uniform {
    /// The distribution over the interval from `low` to `high`, `low < high`.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for ends that are not finite, in the wrong order, equal, or
    /// so far apart that their distance overflows.
    pub fn new(low: f64, high: f64) -> Result<Self> {
        finite("lower end of the interval", low)?;
        finite("upper end of the interval", high)?;
        let positive = |width: f64| width > 0.0 && width.is_finite();
        in_range("width of the interval", "a finite number > 0", high - low, positive)?;
        Ok(Uniform { low, high })
    }

    /// The lower end.
    pub fn low(self) -> f64 {
        self.low
    }

    /// The upper end.
    pub fn high(self) -> f64 {
        self.high
    }

    /// Density at `x`, per unit of the quantity.
    pub fn density(self, x: f64) -> f64 {
        if x.is_nan() {
            return x;
        }
        if (self.low..=self.high).contains(&x) { 1.0 / self.width() } else { 0.0 }
    }

    /// P(X <= x).
    pub fn cdf(self, x: f64) -> f64 {
        (x.clamp(self.low, self.high) - self.low) / self.width()
    }

    /// P(from <= X <= to); 0 where `from` lies above `to`. Either end may be infinite.
    pub fn probability(self, from: f64, to: f64) -> f64 {
        if from > to {
            return 0.0;
        }
        self.cdf(to) - self.cdf(from)
    }

    /// The value that a share `p` of all draws does not exceed: the inverse of
    /// [`cdf`](Uniform::cdf).
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a `p` outside \[0, 1\].
    pub fn quantile(self, p: f64) -> Result<f64> {
        let p = probability("share of the draws", p)?;
        Ok((self.low + p * self.width()).min(self.high))
    }

    /// The expected value, the middle of the interval.
    pub fn mean(self) -> f64 {
        self.low + 0.5 * self.width()
    }

    /// The variance, `width^2 / 12`.
    pub fn variance(self) -> f64 {
        self.width() * self.width() / 12.0
    }

    /// Draws from the distribution.
    pub fn sample<R: Rng + ?Sized>(self, rng: &mut R) -> f64 {
        (self.low + rng.random::<f64>() * self.width()).min(self.high)
    }

    fn width(self) -> f64 {
        self.high - self.low
    }
}
