//! Settings of the tempered update.

use crate::Result;
use loc_core::error::in_range;

/// Settings of [`Tempering`](crate::Tempering).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct TemperingSettings {
    /// A stage takes in as much of the measurement as leaves this share of the particles
    /// effective, in (0, 1).
    pub effective_share: f64,
    /// The most stages of an update; the last one takes in what is left.
    pub most_stages: usize,
    /// The share of the walks that should be accepted, in (0, 1); their length follows it.
    pub acceptance: f64,
}

impl Default for TemperingSettings {
    fn default() -> Self {
        TemperingSettings { effective_share: 0.5, most_stages: 20, acceptance: 0.35 }
    }
}

impl TemperingSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] naming the first that is not allowed.
    pub fn validate(&self) -> Result<()> {
        let share = |v: f64| v > 0.0 && v < 1.0;
        let expected = "a share above 0 and below 1";
        in_range("effective_share of a stage", expected, self.effective_share, share)?;
        in_range("acceptance of the walks", expected, self.acceptance, share)?;
        let stages = self.most_stages as f64;
        in_range("most_stages", "at least 1", stages, |v| v >= 1.0)?;
        Ok(())
    }
}
