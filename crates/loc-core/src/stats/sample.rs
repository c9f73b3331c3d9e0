//! Figures of samples: running moments, quantiles, covariance and correlation (F2).

use crate::error::{finite, in_range, positive, probability};
use crate::{Error, Gaussian, Result};
use nalgebra::{SMatrix, SVector};

/// Count, mean, variance, minimum and maximum of numbers, without keeping them.
///
/// Welford's recurrence (1962): as accurate for numbers far from 0 as for those near it. Two of
/// them [`merge`](RunningMoments::merge) into the moments of all numbers.
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
    /// The moments of an empty sample.
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

    /// Adds the numbers of `other` (Chan, Golub and LeVeque, 1979).
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

/// The value in the middle of the sample, halfway between the two middle ones of an even number.
///
/// # Errors
/// [`Error::Length`] for an empty sample, [`Error::OutOfRange`] for numbers that are not finite.
pub fn median(values: &[f64]) -> Result<f64> {
    quantile(values, 0.5)
}

/// The value that a share `p` of the sample does not exceed.
///
/// Sorted, the n values stand at the shares 0, 1/(n-1), .., 1, and between them the quantile runs
/// along straight lines (type 7 of Hyndman and Fan 1996, the default of NumPy and R).
///
/// # Errors
/// [`Error::Length`] for an empty sample, [`Error::OutOfRange`] for a `p` outside \[0, 1\] and for
/// numbers that are not finite.
pub fn quantile(values: &[f64], p: f64) -> Result<f64> {
    check(values)?;
    let position = probability("share of the sample", p)? * (values.len() - 1) as f64;
    let mut values = values.to_vec();
    let (_, &mut low, above) = values.select_nth_unstable_by(position as usize, f64::total_cmp);
    // The last value has none above it, and a fraction of 0.
    let high = above.iter().copied().min_by(f64::total_cmp).unwrap_or(low);
    let share = position.fract();
    Ok(low * (1.0 - share) + high * share)
}

/// Root mean square: the root of the mean of the squares.
///
/// # Errors
/// [`Error::Length`] for an empty sample, [`Error::OutOfRange`] for numbers that are not finite.
pub fn rms(values: &[f64]) -> Result<f64> {
    check(values)?;
    let squares: f64 = values.iter().map(|value| value * value).sum();
    Ok((squares / values.len() as f64).sqrt())
}

/// Checks that a sample has elements and that all are finite.
fn check(values: &[f64]) -> Result<()> {
    if values.is_empty() {
        return Err(Error::Length { what: "sample", expected: "at least 1", found: 0 });
    }
    for &value in values {
        finite("value of a sample", value)?;
    }
    Ok(())
}

/// Covariance of two samples taken in pairs: the sum of products of deviations from the means, by
/// n - 1.
///
/// # Errors
/// [`Error::Length`] for samples of different lengths or of fewer than two numbers,
/// [`Error::OutOfRange`] for numbers that are not finite.
pub fn covariance(first: &[f64], second: &[f64]) -> Result<f64> {
    Ok(pair_covariance(first, second)?.m12)
}

/// Correlation of two samples taken in pairs: the covariance by both standard deviations, in
/// \[-1, 1\].
///
/// # Errors
/// Those of [`covariance`], and [`Error::OutOfRange`] for a sample that does not vary.
pub fn correlation(first: &[f64], second: &[f64]) -> Result<f64> {
    let matrix = pair_covariance(first, second)?;
    normalized(matrix.m12, matrix.m11, matrix.m22)
}

/// Covariance matrix of sample vectors, with n - 1 as the divisor.
///
/// # Errors
/// [`Error::Length`] for fewer than two samples, [`Error::OutOfRange`] for numbers that are not
/// finite.
pub fn covariance_matrix<const N: usize>(
    samples: &[SVector<f64, N>],
) -> Result<SMatrix<f64, N, N>> {
    Ok(sample_gaussian(samples)?.covariance)
}

/// Mean and covariance matrix of sample vectors, with n - 1 as the divisor.
///
/// # Errors
/// [`Error::Length`] for fewer than two samples, [`Error::OutOfRange`] for numbers that are not
/// finite.
pub fn sample_gaussian<const N: usize>(samples: &[SVector<f64, N>]) -> Result<Gaussian<N>> {
    if samples.len() < 2 {
        return Err(Error::Length { what: "sample", expected: "at least 2", found: samples.len() });
    }
    for &value in samples.iter().flatten() {
        finite("value of a sample", value)?;
    }
    let count = samples.len() as f64;
    let mean = samples.iter().sum::<SVector<f64, N>>() / count;
    let mut covariance = SMatrix::zeros();
    for sample in samples {
        let deviation = sample - mean;
        covariance += deviation * deviation.transpose();
    }
    Ok(Gaussian { mean, covariance: covariance / (count - 1.0) })
}

/// The correlation of a covariance and two variances.
pub(crate) fn normalized(covariance: f64, first: f64, second: f64) -> Result<f64> {
    for variance in [first, second] {
        positive("variance", variance)?;
    }
    let correlation = covariance / (first.sqrt() * second.sqrt());
    // Rounding may carry a perfect correlation past 1, never by much.
    in_range("correlation", "in [-1, 1]", correlation, |r| r.abs() < 1.0 + 1e-6)
        .map(|r| r.clamp(-1.0, 1.0))
}

fn pair_covariance(first: &[f64], second: &[f64]) -> Result<SMatrix<f64, 2, 2>> {
    if first.len() != second.len() {
        return Err(Error::Length {
            what: "second sample",
            expected: "as many as the first has",
            found: second.len(),
        });
    }
    let pairs = first.iter().zip(second);
    let samples: Vec<_> = pairs.map(|(&a, &b)| SVector::from([a, b])).collect();
    covariance_matrix(&samples)
}
