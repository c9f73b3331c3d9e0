//! The figures of a single error, and of a single sequence.

use crate::error::{finite, positive};
use crate::stats::RunningMoments;
use crate::stats::chi_square::check_confidence;
use crate::{Error, Gaussian, Normal, Result};
use nalgebra::{SMatrix, SVector};

/// Normalised estimation error squared, `e^T P^-1 e`, of an error vector (angles wrapped) and the
/// covariance that the estimator claims. The same of an innovation and its covariance is the NIS.
///
/// Chi-square distributed with `N` degrees of freedom where the claim is right.
///
/// # Errors
/// [`Error::OutOfRange`] for an error that is not finite, [`Error::NotACovariance`] for a covariance
/// that is singular or not finite.
pub fn nees<const N: usize>(
    error: &SVector<f64, N>,
    covariance: &SMatrix<f64, N, N>,
) -> Result<f64> {
    for &value in error.iter() {
        finite("estimation error", value)?;
    }
    let claimed = Gaussian { mean: SVector::zeros(), covariance: *covariance };
    claimed.deviation_squared(error)
}

/// Autocorrelation of a sequence with itself `lag` elements later, in \[-1, 1\]:
/// `sum (x_t - m) (x_(t+lag) - m) / sum (x_t - m)^2` with the mean m.
///
/// The innovations of an optimal filter are white: at every lag above 0 this is 0 up to chance,
/// see [`whiteness_bound`]. That their mean is 0 is a test of its own.
///
/// # Errors
/// [`Error::Length`] where the sequence has no more than `lag` elements, [`Error::OutOfRange`] for
/// numbers that are not finite, and for a sequence that does not vary.
pub fn autocorrelation(sequence: &[f64], lag: usize) -> Result<f64> {
    if sequence.len() <= lag {
        return Err(Error::Length {
            what: "sequence",
            expected: "more elements than the lag",
            found: sequence.len(),
        });
    }
    let moments = RunningMoments::of(sequence.iter().copied())?;
    let mean = moments.mean().unwrap_or_default();
    let variance = moments.population_variance().unwrap_or_default();
    let sum_of_squares = positive("variance of the sequence", variance)? * sequence.len() as f64;
    let products = sequence.iter().zip(&sequence[lag..]);
    let sum: f64 = products.map(|(a, b)| (a - mean) * (b - mean)).sum();
    Ok(sum / sum_of_squares)
}

/// How far from 0 the [`autocorrelation`] of a white sequence of `count` elements lies at most, with
/// probability `confidence`: the normal quantile by `sqrt(count)`, good for `count` above about 30.
///
/// # Errors
/// [`Error::Length`] for an empty sequence, [`Error::OutOfRange`] for a `confidence` outside
/// \[0, 1).
pub fn whiteness_bound(count: usize, confidence: f64) -> Result<f64> {
    let confidence = check_confidence(confidence)?;
    if count == 0 {
        return Err(Error::Length { what: "sequence", expected: "at least 1", found: 0 });
    }
    Ok(Normal::STANDARD.quantile(0.5 + 0.5 * confidence)? / (count as f64).sqrt())
}
