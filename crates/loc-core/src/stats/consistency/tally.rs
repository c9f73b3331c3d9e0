//! Normalised squares, counted.

use crate::Result;
use crate::error::non_negative;
use crate::stats::chi_square::{check_confidence, chi_square_interval, mean_band};
use std::ops::RangeInclusive;

/// Normalised squared errors (NIS, NEES) of any degrees of freedom, held against the chi-square
/// distribution.
///
/// ```
/// use loc_core::stats::consistency::ChiSquareTally;
/// let mut nis = ChiSquareTally::new(0.95)?;
/// for (dof, value) in [(2, 1.4), (2, 3.1), (1, 0.2), (2, 12.0)] {
///     nis.push(dof, value)?;
/// }
/// assert_eq!(nis.mean_per_degree(), Some(16.7 / 7.0));
/// assert_eq!(nis.share_inside(), Some(0.75)); // 12 is too much for 2 numbers
/// # Ok::<(), loc_core::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ChiSquareTally {
    confidence: f64,
    count: u64,
    freedom: u64,
    sum: f64,
    inside: u64,
    /// The interval of each number of degrees that has come.
    #[cfg_attr(feature = "serde", serde(skip))]
    intervals: Vec<(usize, RangeInclusive<f64>)>,
}

impl ChiSquareTally {
    /// Nothing counted yet; single values are held against the interval that holds the share
    /// `confidence` of them.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a `confidence` outside \[0, 1).
    pub fn new(confidence: f64) -> Result<Self> {
        let confidence = check_confidence(confidence)?;
        let intervals = Vec::new();
        Ok(ChiSquareTally { confidence, count: 0, freedom: 0, sum: 0.0, inside: 0, intervals })
    }

    /// Counts a value of `dof` degrees of freedom.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a value that is negative or not finite, and for a `dof`
    /// outside 1..=10^8; nothing is then counted.
    pub fn push(&mut self, dof: usize, value: f64) -> Result<()> {
        non_negative("normalised squared error", value)?;
        let inside = self.interval(dof)?.contains(&value);
        self.count += 1;
        self.freedom += dof as u64;
        self.sum += value;
        self.inside += u64::from(inside);
        Ok(())
    }

    /// Adds what `other` has counted. Each keeps to its own confidence.
    pub fn merge(&mut self, other: &ChiSquareTally) {
        self.count += other.count;
        self.freedom += other.freedom;
        self.sum += other.sum;
        self.inside += other.inside;
    }

    fn interval(&mut self, dof: usize) -> Result<&RangeInclusive<f64>> {
        let known = self.intervals.iter().position(|(known, _)| *known == dof);
        let index = match known {
            Some(index) => index,
            None => {
                self.intervals.push((dof, chi_square_interval(dof, self.confidence)?));
                self.intervals.len() - 1
            }
        };
        Ok(&self.intervals[index].1)
    }

    /// How many values there were.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Their degrees of freedom together.
    pub fn degrees_of_freedom(&self) -> u64 {
        self.freedom
    }

    /// Their mean; `None` without values.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }

    /// Their sum by their degrees of freedom: 1 where the claims are right. `None` without values.
    pub fn mean_per_degree(&self) -> Option<f64> {
        (self.freedom > 0).then(|| self.sum / self.freedom as f64)
    }

    /// Where [`mean_per_degree`](Self::mean_per_degree) lies with the tally's confidence, if the
    /// values are independent, as innovations of an honest filter are. `None` without values.
    pub fn band_per_degree(&self) -> Option<RangeInclusive<f64>> {
        mean_band(self.freedom, self.confidence)
    }

    /// The share of the values that lie within the interval that should hold the share
    /// `confidence` of them. `None` without values.
    pub fn share_inside(&self) -> Option<f64> {
        (self.count > 0).then(|| self.inside as f64 / self.count as f64)
    }
}
