//! The chi-square distribution of normalised squared errors, and confidence intervals of means and
//! probabilities.

use super::RunningMoments;
use crate::error::{in_range, non_negative};
use crate::{Error, Normal, Result};
use statrs::distribution::{ChiSquared, Continuous, ContinuousCDF, StudentsT};
use std::ops::RangeInclusive;

/// Upper bound of the degrees of freedom: beyond it the series of the distribution lose digits.
const MAX_FREEDOM: usize = 100_000_000;

/// P(X <= x) of the chi-square distribution with `dof` degrees of freedom; `1 - cdf` is the
/// p-value of a squared Mahalanobis distance `x`.
///
/// # Errors
/// [`Error::OutOfRange`] for a `dof` outside 1..=10^8, and an `x` that is negative or not finite.
pub fn chi_square_cdf(dof: usize, x: f64) -> Result<f64> {
    Ok(distribution(dof)?.cdf(non_negative("chi-square value", x)?))
}

/// The value that a share `p` of all draws from the chi-square distribution with `dof` degrees of
/// freedom does not exceed: the gate for squared Mahalanobis distances.
///
/// # Errors
/// [`Error::OutOfRange`] for a `dof` outside 1..=10^8, and a `p` outside \[0, 1).
pub fn chi_square_quantile(dof: usize, p: f64) -> Result<f64> {
    let below_one = |p: f64| (0.0..1.0).contains(&p);
    let p = in_range("share of the draws", "a probability in [0, 1)", p, below_one)?;
    let chi_square = distribution(dof)?;
    Ok(polish(&chi_square, chi_square.inverse_cdf(p), p))
}

/// The interval that holds the share `confidence` of all draws from the chi-square distribution
/// with `dof` degrees of freedom, and leaves out as many below as above.
///
/// # Errors
/// [`Error::OutOfRange`] for a `dof` outside 1..=10^8, and a `confidence` outside \[0, 1).
pub fn chi_square_interval(dof: usize, confidence: f64) -> Result<RangeInclusive<f64>> {
    let tail = 0.5 * (1.0 - check_confidence(confidence)?);
    Ok(chi_square_quantile(dof, tail)?..=chi_square_quantile(dof, 1.0 - tail)?)
}

/// Where the mean of `runs` independent NEES (or NIS) values of `dof` degrees of freedom lies with
/// probability `confidence`, if the estimator's covariances are right
/// (Bar-Shalom, Li and Kirubarajan 2001, section 5.4).
///
/// A mean above the band indicates an overconfident estimator, one below an underconfident one.
///
/// # Errors
/// [`Error::OutOfRange`] where `dof * runs` is outside 1..=10^8, and for a `confidence` outside
/// \[0, 1).
pub fn chi_square_band(dof: usize, runs: usize, confidence: f64) -> Result<RangeInclusive<f64>> {
    let sum = chi_square_interval(dof.saturating_mul(runs), confidence)?;
    let runs = runs as f64;
    Ok(sum.start() / runs..=sum.end() / runs)
}

/// Where the mean per degree of freedom of values with `freedom` degrees together lies with
/// probability `confidence`. Beyond [`MAX_FREEDOM`] the normal approximation is used. `None`
/// without any.
pub(super) fn mean_band(freedom: u64, confidence: f64) -> Option<RangeInclusive<f64>> {
    let count = usize::try_from(freedom).ok().filter(|count| *count > 0)?;
    if count <= MAX_FREEDOM {
        return chi_square_band(1, count, confidence).ok();
    }
    let z = Normal::STANDARD.quantile(0.5 + 0.5 * check_confidence(confidence).ok()?).ok()?;
    let reach = z * (2.0 / freedom as f64).sqrt();
    Some(1.0 - reach..=1.0 + reach)
}

/// Checks that a confidence is in \[0, 1).
pub(super) fn check_confidence(confidence: f64) -> Result<f64> {
    in_range("confidence", "a probability in [0, 1)", confidence, |c| (0.0..1.0).contains(&c))
}

/// The quantile to its last digits, from one that is right to 1e-9 or so, absolutely.
///
/// Newton's method on ln F over ln x, which is a straight line where x is small.
fn polish(chi_square: &ChiSquared, start: f64, p: f64) -> f64 {
    let mut x = start;
    for _ in 0..4 {
        let cdf = chi_square.cdf(x);
        let step = cdf / (x * chi_square.pdf(x)) * (cdf / p).ln();
        if !step.is_finite() {
            break;
        }
        x *= (-step).exp();
    }
    x
}

fn distribution(dof: usize) -> Result<ChiSquared> {
    let refused = || Error::OutOfRange {
        what: "degrees of freedom",
        expected: "1 to 10^8",
        found: dof as f64,
    };
    if !(1..=MAX_FREEDOM).contains(&dof) {
        return Err(refused());
    }
    ChiSquared::new(dof as f64).map_err(|_| refused())
}

/// The interval that holds the expected value of a number with probability `confidence`, by
/// Student's distribution: `mean -+ t s / sqrt(n)`. Exact for normally distributed numbers, good
/// for others from some ten on. `None` for fewer than two numbers.
///
/// # Errors
/// [`Error::OutOfRange`] for a `confidence` outside \[0, 1).
pub fn mean_interval(
    moments: &RunningMoments,
    confidence: f64,
) -> Result<Option<RangeInclusive<f64>>> {
    let tail = 0.5 + 0.5 * check_confidence(confidence)?;
    let (Some(mean), Some(sigma)) = (moments.mean(), moments.standard_deviation()) else {
        return Ok(None);
    };
    let count = moments.count() as f64;
    let Ok(student) = StudentsT::new(0.0, 1.0, count - 1.0) else { return Ok(None) };
    let reach = student.inverse_cdf(tail) * sigma / count.sqrt();
    Ok(reach.is_finite().then_some(mean - reach..=mean + reach))
}

/// The interval that holds the probability of a success with `confidence`, after `successes` of
/// `count` trials (Wilson 1927). It stays within \[0, 1\], and 0 of n does not give the
/// interval \[0, 0\].
///
/// ```
/// let interval = loc_core::stats::wilson_interval(10, 10, 0.95)?;
/// assert!((interval.start() - 0.7225).abs() < 1e-4 && *interval.end() == 1.0);
/// # Ok::<(), loc_core::Error>(())
/// ```
///
/// # Errors
/// [`Error::Length`] without trials, or with fewer trials than successes; [`Error::OutOfRange`]
/// for a `confidence` outside \[0, 1).
pub fn wilson_interval(successes: u64, count: u64, confidence: f64) -> Result<RangeInclusive<f64>> {
    let tail = 0.5 + 0.5 * check_confidence(confidence)?;
    if count == 0 || successes > count {
        let expected = "at least 1, and as many as there were successes";
        return Err(Error::Length { what: "trials", expected, found: count as usize });
    }
    let z = Normal::STANDARD.quantile(tail)?;
    let (n, share) = (count as f64, successes as f64 / count as f64);
    let shrink = 1.0 + z * z / n;
    let centre = (share + 0.5 * z * z / n) / shrink;
    let reach = z / shrink * (share * (1.0 - share) / n + 0.25 * z * z / (n * n)).sqrt();
    // At the ends the formula gives exactly 0 and 1, but for rounding.
    let low = if successes == 0 { 0.0 } else { (centre - reach).max(0.0) };
    let high = if successes == count { 1.0 } else { (centre + reach).min(1.0) };
    Ok(low..=high)
}
