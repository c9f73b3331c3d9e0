//! What "lost" means, and the constants of the fit.

use super::{ScanFit, Tolerance};
use crate::Result;
use loc_core::error::{finite, in_range, non_negative};

/// Settings of a [`LostMonitor`](super::LostMonitor).
///
/// The constants after `tolerance` belong together: they are the fit of the test
/// `lost::fit_the_constants` to drives through simulated offices.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct LostSettings {
    /// How far off the reported pose may be.
    pub tolerance: Tolerance,
    /// Share of the log odds that stays from one update to the next.
    pub memory: f64,
    /// Shift of the log odds by a scan that fits no better than at the best of the random poses,
    /// with no beam blocked or near.
    pub bias: f64,
    /// How much a margin over the best of the random poses speaks against being lost.
    pub margin_weight: f64,
    /// How much blocked beams speak for it.
    pub blocked_weight: f64,
    /// How much beams that end near obstacles do.
    pub near_weight: f64,
    /// How much the belief's own spread counts beside the scans: 0 for not at all.
    pub support_exponent: f64,
}

impl Default for LostSettings {
    fn default() -> Self {
        LostSettings {
            tolerance: Tolerance::default(),
            memory: 0.625,
            bias: -2.478,
            margin_weight: 2.544,
            blocked_weight: 1.246,
            near_weight: 0.4545,
            support_exponent: 1.089,
        }
    }
}

/// The share of beams at which their weight begins to count by the logarithm: a beam of 50 may go
/// astray anywhere.
const STRAY: f64 = 0.02;

impl LostSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] naming the first that is not allowed.
    pub fn validate(&self) -> Result<()> {
        self.tolerance.validate()?;
        let share = |memory: f64| (0.0..1.0).contains(&memory);
        in_range("memory of the lost figure", "from 0 to below 1", self.memory, share)?;
        finite("bias", self.bias)?;
        non_negative("margin_weight", self.margin_weight)?;
        non_negative("blocked_weight", self.blocked_weight)?;
        non_negative("near_weight", self.near_weight)?;
        non_negative("support_exponent", self.support_exponent)?;
        Ok(())
    }

    /// By how much a scan shifts the log odds of a wrong belief, see [`crate::confidence`].
    pub fn shift(&self, scan: &ScanFit<'_>) -> f64 {
        let [blocked, near] = [scan.blocked, scan.near].map(|share| (share / STRAY).ln_1p());
        self.bias - self.margin_weight * scan.margin()
            + self.blocked_weight * blocked
            + self.near_weight * near
    }
}
