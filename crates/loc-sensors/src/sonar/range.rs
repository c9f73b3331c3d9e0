//! The measurement: one echo.

use crate::Result;
use crate::check::{in_range, reach};
use std::f64::consts::TAU;

/// One distance, with the meaning of the ROS message `Range`: -inf too close, +inf no echo, NaN
/// an error (REP-117).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct SonarRange {
    /// Distance \[m\].
    pub range: f64,
    /// Full opening angle of the cone in which the echo may have been \[rad\].
    pub cone: f64,
    /// Shortest distance that is a measurement \[m\].
    pub range_min: f64,
    /// Longest distance that is a measurement \[m\].
    pub range_max: f64,
}

impl SonarRange {
    /// Whether the distance is a measurement.
    pub fn is_valid(&self) -> bool {
        (self.range_min..=self.range_max).contains(&self.range)
    }

    /// Checks the numbers around the distance.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a cone that is not positive, or limits in the wrong order.
    pub fn check(&self) -> Result<()> {
        let opens = |cone: f64| cone > 0.0 && cone <= TAU;
        in_range("cone of a sonar [rad]", "above 0, at most a turn", self.cone, opens)?;
        reach(self.range_min, self.range_max)
    }
}
