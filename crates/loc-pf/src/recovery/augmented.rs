//! Augmented Monte Carlo localization: how many random particles the last scans call for.

use crate::Result;
use loc_core::error::in_range;

/// Settings of [`AugmentedMcl`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct AugmentedSettings {
    /// Share by which the long-term average follows each update (`recovery_alpha_slow`).
    pub alpha_slow: f64,
    /// Share by which the short-term average does (`recovery_alpha_fast`), above `alpha_slow`.
    pub alpha_fast: f64,
}

impl Default for AugmentedSettings {
    /// The values of the literature.
    fn default() -> Self {
        AugmentedSettings { alpha_slow: 0.001, alpha_fast: 0.1 }
    }
}

impl AugmentedSettings {
    /// Checks both numbers.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] unless 0 < alpha_slow < alpha_fast <= 1.
    pub fn validate(&self) -> Result<()> {
        let fast = |v: f64| v > 0.0 && v <= 1.0;
        in_range("alpha_fast", "a number above 0 and up to 1", self.alpha_fast, fast)?;
        let slow = |v: f64| v > 0.0 && v < self.alpha_fast;
        in_range("alpha_slow", "a number above 0 and below alpha_fast", self.alpha_slow, slow)?;
        Ok(())
    }
}

/// Two running averages of the likelihood of the scans, a slow and a fast one; when the fast one
/// falls below the slow one, the share missing is the share of random particles to inject
/// (Probabilistic Robotics, table 8.3).
///
/// The averages are kept as logarithms: likelihoods of many beams are far below the smallest
/// number. The evidence must be that of the weights **before** they are normalised.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AugmentedMcl {
    settings: AugmentedSettings,
    /// Logarithms of the slow and the fast average, once there has been an update.
    averages: Option<(f64, f64)>,
}

impl AugmentedMcl {
    /// Averages without a past.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`], see [`AugmentedSettings::validate`].
    pub fn new(settings: AugmentedSettings) -> Result<Self> {
        settings.validate()?;
        Ok(AugmentedMcl { settings, averages: None })
    }

    /// Takes in `ln(mean likelihood of the particles)`; returns the share of the cloud to replace
    /// by random particles, in \[0, 1\].
    // ANCHOR: augmented
    pub fn update(&mut self, log_evidence: f64) -> f64 {
        if log_evidence.is_nan() {
            return 0.0;
        }
        let (slow, fast) = self.averages.unwrap_or((log_evidence, log_evidence));
        let slow = mix(slow, log_evidence, self.settings.alpha_slow);
        let fast = mix(fast, log_evidence, self.settings.alpha_fast);
        self.averages = Some((slow, fast));
        let share = 1.0 - (fast - slow).exp();
        // Both averages are -inf where nothing was ever likely.
        if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) }
    }
    // ANCHOR_END: augmented

    /// Forgets the past, after the cloud was spread anew.
    pub fn reset(&mut self) {
        self.averages = None;
    }
}

/// ln((1 - share) exp(old) + share exp(new)).
fn mix(old: f64, new: f64, share: f64) -> f64 {
    let (a, b) = (old + (1.0 - share).ln(), new + share.ln());
    let largest = a.max(b);
    if largest.is_finite() {
        largest + ((a - largest).exp() + (b - largest).exp()).ln()
    } else {
        largest
    }
}
