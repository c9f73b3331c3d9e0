//! Settings of the tempered update.

use crate::Result;
use loc_core::error::{in_range, positive};

/// Settings of [`Tempering`](crate::Tempering).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct TemperingSettings {
    /// A stage takes in as much of the measurement as leaves this share of the particles
    /// effective, in (0, 1).
    pub effective_share: f64,
    /// The most stages of an update; the last one takes in what is left.
    pub max_stages: usize,
    /// The share of the strides that should be accepted, in (0, 1); their length follows it.
    pub acceptance: f64,
    /// Particles walk on until there are so many accepted strides to each of them on the average ..
    pub moves: f64,
    /// .. but so many strides at the most.
    pub max_strides: usize,
}

impl Default for TemperingSettings {
    fn default() -> Self {
        TemperingSettings {
            effective_share: 0.5,
            max_stages: 20,
            acceptance: 0.35,
            moves: 0.5,
            max_strides: 10,
        }
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
        positive("moves of a stage", self.moves)?;
        let strides = self.max_strides as f64;
        in_range("max_strides", "at least 1", strides, |v| v >= 1.0)?;
        let stages = self.max_stages as f64;
        in_range("max_stages", "at least 1", stages, |v| v >= 1.0)?;
        Ok(())
    }
}
