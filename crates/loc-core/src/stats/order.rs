//! Median, quantiles and root mean square of a sample.

use crate::error::{finite, probability};
use crate::{Error, Result};

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
