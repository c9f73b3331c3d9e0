//! How far a sample may be off.

use crate::Result;
use loc_core::error::{non_negative, positive};

/// Errors of one axis; the unit U is m/s^2 or rad/s.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct InertialNoise {
    /// Density of the white noise \[U/sqrt(Hz)\]; also known as velocity or angle random walk.
    pub density: f64,
    /// Density of the noise that the bias sums up \[U/s/sqrt(Hz)\]; also known as rate random walk.
    pub bias_walk: f64,
    /// Standard deviation of the bias when the device starts \[U\].
    pub start_bias: f64,
    /// The device measures up to this, either way \[U\].
    pub limit: f64,
}

impl InertialNoise {
    /// A perfect axis.
    pub const NONE: InertialNoise =
        InertialNoise { density: 0.0, bias_walk: 0.0, start_bias: 0.0, limit: f64::MAX };

    /// Standard deviation of the white noise of a sample that averages over `dt` \[s\].
    pub fn sample_sigma(&self, dt: f64) -> f64 {
        self.density / dt.sqrt()
    }

    /// Standard deviation of what the bias wanders in `dt` \[s\].
    pub fn bias_step_sigma(&self, dt: f64) -> f64 {
        self.bias_walk * dt.sqrt()
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for negative values, NaN and infinity, and a limit that is not
    /// positive.
    pub fn check(&self) -> Result<()> {
        non_negative("noise density of an inertial sensor", self.density)?;
        non_negative("bias walk of an inertial sensor", self.bias_walk)?;
        non_negative("bias at start of an inertial sensor", self.start_bias)?;
        positive("limit of an inertial sensor", self.limit)?;
        Ok(())
    }
}
