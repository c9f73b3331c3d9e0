//! Covariance and correlation of samples (F2).

use crate::error::{finite, in_range, positive};
use crate::{Error, Gaussian, Result};
use nalgebra::{SMatrix, SVector};

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
