//! Mean and spread of numbers that come one at a time.

use crate::Result;
use crate::error::finite;

/// Count, mean, variance, minimum and maximum of numbers, without keeping them.
///
/// Welford's recurrence (1962): as accurate for numbers far from 0 as for those near it. Two of
/// them [`merge`](RunningMoments::merge) as if one had seen everything.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunningMoments {
    count: u64,
    mean: f64,
    /// Sum of the squared deviations from the mean.
    squares: f64,
    min: f64,
    max: f64,
}

impl Default for RunningMoments {
    fn default() -> Self {
        RunningMoments {
            count: 0,
            mean: 0.0,
            squares: 0.0,
            min: f64::INFINITY,
            max: f64::NEG_INFINITY,
        }
    }
}

impl RunningMoments {
    /// The moments of nothing yet.
    pub fn new() -> Self {
        RunningMoments::default()
    }

    /// The moments of all `values`.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a value that is not finite.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Result<Self> {
        let mut moments = RunningMoments::new();
        for value in values {
            moments.push(value)?;
        }
        Ok(moments)
    }

    /// Adds a number.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for NaN and infinity; the moments stay as they were.
    pub fn push(&mut self, value: f64) -> Result<()> {
        finite("value of a sample", value)?;
        self.count += 1;
        let deviation = value - self.mean;
        self.mean += deviation / self.count as f64;
        self.squares += deviation * (value - self.mean);
        self.min = self.min.min(value);
        self.max = self.max.max(value);
        Ok(())
    }

    /// Adds all that `other` has seen (Chan, Golub and LeVeque, 1979).
    pub fn merge(&mut self, other: &RunningMoments) {
        if other.count == 0 {
            return;
        }
        let (n, m) = (self.count as f64, other.count as f64);
        let deviation = other.mean - self.mean;
        self.mean += deviation * (m / (n + m));
        self.squares += other.squares + deviation * deviation * (n * m / (n + m));
        self.count += other.count;
        self.min = self.min.min(other.min);
        self.max = self.max.max(other.max);
    }

    /// How many numbers there were.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The mean; `None` without numbers.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then_some(self.mean)
    }

    /// The variance of the distribution that the numbers are a sample of: the sum of squared
    /// deviations by n - 1. `None` for fewer than two numbers.
    pub fn variance(&self) -> Option<f64> {
        (self.count > 1).then(|| self.squares / (self.count - 1) as f64)
    }

    /// The variance of the numbers themselves: the sum of squared deviations by n. `None` without
    /// numbers.
    pub fn population_variance(&self) -> Option<f64> {
        (self.count > 0).then(|| self.squares / self.count as f64)
    }

    /// The root of [`variance`](RunningMoments::variance).
    pub fn standard_deviation(&self) -> Option<f64> {
        self.variance().map(f64::sqrt)
    }

    /// The smallest number; `None` without numbers.
    pub fn min(&self) -> Option<f64> {
        (self.count > 0).then_some(self.min)
    }

    /// The largest number; `None` without numbers.
    pub fn max(&self) -> Option<f64> {
        (self.count > 0).then_some(self.max)
    }
}
