//! How far an echo may be off.

use crate::Result;
use crate::check::in_range;
use loc_core::error::{non_negative, probability};

/// Normal errors of the distance, and echoes that are missed or of another sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct SonarNoise {
    /// Standard deviation of the distance at the sensor \[m\].
    pub sigma: f64,
    /// Its growth with the distance \[m/m\]; temperature changes the speed of sound.
    pub sigma_per_m: f64,
    /// Probability that an echo is missed: +inf.
    pub dropout: f64,
    /// Probability that the sound of another sensor is heard: any shorter distance.
    pub crosstalk: f64,
}

impl SonarNoise {
    /// A perfect sensor.
    pub const NONE: SonarNoise =
        SonarNoise { sigma: 0.0, sigma_per_m: 0.0, dropout: 0.0, crosstalk: 0.0 };

    /// Standard deviation of a distance of `range` \[m\].
    pub fn sigma_at(&self, range: f64) -> f64 {
        self.sigma + self.sigma_per_m * range
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for negative values, NaN and infinity, and for probabilities
    /// outside \[0, 1\] or with a sum above 1.
    pub fn check(&self) -> Result<()> {
        non_negative("sigma of a sonar's range [m]", self.sigma)?;
        non_negative("growth of a sonar's sigma [m/m]", self.sigma_per_m)?;
        probability("probability of a missed echo", self.dropout)?;
        probability("probability of crosstalk", self.crosstalk)?;
        let sum = self.dropout + self.crosstalk;
        in_range("sum of a sonar's fault probabilities", "at most 1", sum, |sum| sum <= 1.0)?;
        Ok(())
    }
}
