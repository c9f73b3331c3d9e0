//! How well a few runs tell what all runs would do.

use super::RunningMoments;
use super::chi_square::check_confidence;
use crate::{Error, Normal, Result};
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::ops::RangeInclusive;

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
/// `count` trials (Wilson 1927). It stays within \[0, 1\], and 0 of n does not pass for proof that
/// there are none.
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
