//! When to resample (M11).
//!
//! Resampling costs diversity: every time, some particles vanish for ever. Without measurements
//! that tell particles apart there is nothing to gain from it, and a robot that stands still would
//! lose its cloud to chance. So one resamples only every N-th update, or only when the weights
//! have become unequal; in between, the weights of the updates multiply up.
//!
//! ```
//! use loc_pf::policy::{ResamplePolicy, ResampleWhen};
//! let policy = ResamplePolicy { every: 2, when: ResampleWhen::EffectiveShareBelow(0.5) };
//! assert!(policy.is_due(2, 300.0, 1000));
//! assert!(!policy.is_due(1, 300.0, 1000), "only one update since the last time");
//! assert!(!policy.is_due(2, 700.0, 1000), "the weights are still much alike");
//! ```

use crate::Result;
use loc_core::error::{in_range, non_negative};

/// When to resample: at every N-th update at the earliest, and then if the weights ask for it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct ResamplePolicy {
    /// Fewest updates from one resampling to the next (`resample_interval`); 0 counts as 1.
    pub every: usize,
    /// What the weights must be like.
    pub when: ResampleWhen,
}

/// What the weights must be like for resampling.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum ResampleWhen {
    /// Anything.
    Always,
    /// Resampling is switched off.
    Never,
    /// The effective sample size is below this share of the particles, in \[0, 1\].
    EffectiveShareBelow(f64),
    /// The variance of the weights, in units of the mean weight, is above this. It is 0 for
    /// equal weights and M - 1 where one particle has them all; 1 means half of the particles
    /// effective.
    WeightVarianceAbove(f64),
}

impl Default for ResamplePolicy {
    /// At any update that leaves less than half of the particles effective.
    fn default() -> Self {
        ResamplePolicy { every: 1, when: ResampleWhen::EffectiveShareBelow(0.5) }
    }
}

impl ResamplePolicy {
    /// Checks the thresholds.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a share outside \[0, 1\] and a negative variance.
    pub fn validate(&self) -> Result<()> {
        match self.when {
            ResampleWhen::Always | ResampleWhen::Never => {}
            ResampleWhen::EffectiveShareBelow(share) => {
                let allowed = |share: f64| (0.0..=1.0).contains(&share);
                in_range("effective share of the particles", "a share in [0, 1]", share, allowed)?;
            }
            ResampleWhen::WeightVarianceAbove(variance) => {
                non_negative("variance of the weights [-]", variance)?;
            }
        }
        Ok(())
    }

    /// Whether to resample `updates` updates after the last time, with `particles` particles of
    /// the given effective sample size ([`Particles::effective_sample_size`]).
    ///
    /// [`Particles::effective_sample_size`]: crate::Particles::effective_sample_size
    pub fn is_due(&self, updates: usize, effective_sample_size: f64, particles: usize) -> bool {
        let particles = particles as f64;
        let weights_ask = match self.when {
            ResampleWhen::Always => true,
            ResampleWhen::Never => false,
            ResampleWhen::EffectiveShareBelow(share) => effective_sample_size < share * particles,
            ResampleWhen::WeightVarianceAbove(variance) => {
                particles > (1.0 + variance) * effective_sample_size
            }
        };
        updates >= self.every && weights_ask
    }
}
