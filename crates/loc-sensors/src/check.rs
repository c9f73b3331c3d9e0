//! Checks that several sensors share.

use crate::{Error, Result};
use loc_core::Pose2;
pub(crate) use loc_core::error::in_range;
use loc_core::error::{finite, non_negative};

/// Checks that a count lies in 1..=`max`, in words `expected`.
pub(crate) fn count(
    what: &'static str,
    expected: &'static str,
    max: usize,
    found: usize,
) -> Result<usize> {
    if (1..=max).contains(&found) {
        Ok(found)
    } else {
        Err(Error::Length { what, expected, found })
    }
}

/// Checks that `min` and `max` are finite, `min` is not negative, and `max` lies above it.
pub(crate) fn reach(min: f64, max: f64) -> Result<()> {
    non_negative("nearest range [m]", min)?;
    in_range("farthest range [m]", "a finite number above the nearest range", max, |max| {
        max.is_finite() && max > min
    })?;
    Ok(())
}

/// Checks that a pose is finite.
pub(crate) fn finite_pose(what: &'static str, pose: Pose2) -> Result<()> {
    for value in [pose.x, pose.y, pose.theta] {
        finite(what, value)?;
    }
    Ok(())
}
