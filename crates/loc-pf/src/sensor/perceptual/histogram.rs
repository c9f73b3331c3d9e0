//! Counts of expected and measured ranges.

use super::{PerceptualModel, RangePair};
use crate::Result;
use loc_core::error::{in_range, positive};

/// Most bins along an axis.
const MAX_BINS: f64 = 4096.0;

/// How often a range was measured where another one was expected.
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
