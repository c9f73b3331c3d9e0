//! How far a depth may be off.

use crate::Result;
use crate::check::in_range;
use loc_core::error::{non_negative, probability};

/// Errors of the disparity, from which those of the depth follow:
/// `sigma_z = z^2 / (f b) sigma_disparity` with focal length f and base b (Khoshelham and Elberink
/// 2012).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct DisparityNoise {
    /// Standard deviation of the disparity before it is rounded \[px\].
    pub sigma: f64,
    /// What the disparity is rounded to \[px\]; 0 for not at all.
    pub step: f64,
    /// Probability that a pixel measures nothing.
    pub dropout: f64,
}

impl DisparityNoise {
    /// A perfect camera.
    pub const NONE: DisparityNoise = DisparityNoise { sigma: 0.0, step: 0.0, dropout: 0.0 };

    /// Standard deviation of the disparity after rounding \[px\].
    pub fn rounded_sigma(&self) -> f64 {
        (self.sigma * self.sigma + self.step * self.step / 12.0).sqrt()
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for negative values, NaN and infinity, rounding to more than a
    /// pixel, and a probability outside \[0, 1\].
    pub fn check(&self) -> Result<()> {
        non_negative("sigma of the disparity [px]", self.sigma)?;
        let fine = |step: f64| (0.0..=1.0).contains(&step);
        in_range("step of the disparity [px]", "a number in [0, 1]", self.step, fine)?;
        probability("probability that a pixel measures nothing", self.dropout)?;
        Ok(())
    }
}
