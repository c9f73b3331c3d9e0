//! Cumulative weights, which all schemes draw from: one interval for each particle.

use crate::elementary::{ROUND, exp};
use crate::log_weights;
use crate::workers::{PART, Workers};
use pulp::{Arch, Simd, WithSimd};

/// Cumulative weights (the lectures' wheel): one interval for each particle, as wide as its weight.
///
/// Widths are whole numbers: the widest interval has `2^(51 - log2 M)`, rounded down to a power of
/// two, so that sums are exact in every order, equal weights have exactly equal intervals, and
/// rounding never moves a border. A weight below 3e-11 of the largest (at M = 100000; 5e-13 at
/// 2000) counts as 0.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CumulativeWeights {
    /// Where the intervals end; a whole number below 2^52.
    ends: Vec<f64>,
    /// The last interval that is not empty, where rounding may lead at the upper end.
    last: usize,
}

impl CumulativeWeights {
    /// Without intervals.
    pub fn new() -> Self {
        CumulativeWeights::default()
    }

    /// Sets the intervals from the logarithms of weights, which need not add up to 1.
    ///
    /// NaN counts as -inf. Where no weight is finite, or one is infinite, all intervals are equal.
    pub fn set(&mut self, log_weights: &[f64]) {
        self.set_by(&Workers::one(), log_weights);
    }

    /// The same by several threads.
    pub(crate) fn set_by(&mut self, workers: &Workers, log_weights: &[f64]) {
        self.ends.resize(log_weights.len(), 0.0);
        let largest = log_weights::largest_of_all(workers, log_weights);
        let unit = unit(log_weights.len());
        let parts = self.ends.chunks_mut(PART).zip(log_weights.chunks(PART));
        let widths = workers.map(parts, |(ends, log_weights)| {
            Arch::new().dispatch(Set { log_weights, ends, largest, unit })
        });
        let mut before = 0.0;
        let parts = self.ends.chunks_mut(PART).zip(widths).map(|(ends, width)| {
            let start = before;
            before += width;
            (ends, start)
        });
        workers.for_each(parts, |(ends, start)| Arch::new().dispatch(Shift { ends, start }));
        let total = self.total();
        self.last = self.ends.partition_point(|&end| end < total);
    }

    /// Number of intervals.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The particle whose interval lies at `share` of the total, in \[0, 1); never one of weight
    /// 0. O(log M).
    pub fn index_at(&self, share: f64) -> usize {
        let at = share * self.total();
        self.ends.partition_point(|&end| end <= at).min(self.last)
    }

    /// Where the intervals end, in whole units, in order.
    pub(super) fn ends(&self) -> &[f64] {
        &self.ends
    }

    /// All intervals together.
    pub(super) fn total(&self) -> f64 {
        self.ends.last().copied().unwrap_or(0.0)
    }

    /// The last interval that is not empty.
    pub(super) fn last(&self) -> usize {
        self.last
    }
}

/// Fills a part with the running sums of its intervals' widths; all of them together.
struct Set<'a> {
    log_weights: &'a [f64],
    ends: &'a mut [f64],
    /// The logarithm of the largest of all weights.
    largest: f64,
    /// The width of its interval.
    unit: f64,
}

impl WithSimd for Set<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        if self.largest.is_finite() {
            for (end, weight) in self.ends.iter_mut().zip(self.log_weights) {
                *end = (exp(weight - self.largest) * self.unit + ROUND) - ROUND;
            }
        } else {
            self.ends.fill(self.unit);
        }
        add_up(self.ends)
    }
}

/// Moves the intervals of a part behind those of the parts before it.
struct Shift<'a> {
    ends: &'a mut [f64],
    start: f64,
}

impl WithSimd for Shift<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.ends.iter_mut().for_each(|end| *end += self.start);
    }
}

/// Intervals added up side by side.
const LANES: usize = 8;

/// The width of the widest of `count` intervals: all together stay below 2^52.
#[inline(always)]
fn unit(count: usize) -> f64 {
    let bits = usize::BITS - count.leading_zeros();
    (1_u64 << 51_u32.saturating_sub(bits)) as f64
}

/// Replaces widths by their running sums; the last of these.
#[inline(always)]
fn add_up(widths: &mut [f64]) -> f64 {
    let mut total = 0.0;
    let (chunks, rest) = widths.as_chunks_mut::<LANES>();
    for chunk in chunks {
        *chunk = prefix_sums(*chunk).map(|sum| sum + total);
        total = chunk[LANES - 1];
    }
    for width in rest {
        total += *width;
        *width = total;
    }
    total
}

/// Sums of the first 1, 2, .. numbers, in three steps of eight sums each instead of seven that wait
/// for each other; the numbers are whole, so the order changes nothing.
#[inline(always)]
fn prefix_sums(mut sums: [f64; LANES]) -> [f64; LANES] {
    for step in [1, 2, 4] {
        let before = sums;
        for lane in step..LANES {
            sums[lane] = before[lane] + before[lane - step];
        }
    }
    sums
}
