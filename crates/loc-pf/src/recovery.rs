//! Recovery of a robot that was kidnapped or is lost for another reason (A3).
//!
//! A particle set that tracks one pose does not find another by itself. [`AugmentedMcl`] replaces a
//! share of it by particles from the whole map when scans fit worse than before. [`Suspicion`] is
//! more selective: a Bayes filter over two states, the robot at the particles or anywhere else,
//! which requires a global search only when the second becomes likely.
//!
//! ```
//! use loc_pf::recovery::{AugmentedMcl, AugmentedSettings};
//! let mut recovery = AugmentedMcl::new(AugmentedSettings::default())?;
//! assert_eq!(recovery.update(-50.0), 0.0);
//! // A scan that fits e^30 times worse: the fast average loses a tenth, the slow one hardly any.
//! assert!((recovery.update(-80.0) - (1.0 - 0.9 / 0.999)).abs() < 1e-9);
//! # Ok::<(), loc_pf::Error>(())
//! ```

use crate::Result;
use loc_core::error::positive;

/// Probability of being elsewhere from which a search is required.
const ALARM: f64 = 0.1;

/// Share by which the usual evidence follows each update.
const ADAPTATION: f64 = 0.05;

/// Maximum number of updates between a search without result and the next.
const MAX_PAUSE: u32 = 16;

loc_core::settings! {
    /// Settings of [`Suspicion`].
    #[derive(Copy)]
    pub struct SuspicionSettings {
        /// Probability that the robot is kidnapped, or lost, between two updates.
        pub rate: f64 = 1e-3 => probability;
        /// Volume of a pose candidate in the space of poses \[m^2 rad\]: about what a sharp scan
        /// leaves.
        pub place: f64 = 0.01 => positive;
    }
}

/// Log-likelihood of a scan at the true pose \[nats per beam\].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct UsualEvidence {
    /// Expected value, before the first scan.
    pub expected: f64,
    /// Minimum: the running average of a changed world counts only down to this value.
    pub min: f64,
}

/// The probability that the robot is not at its particles.
///
/// Every scan is evidence for both states. The evidence for the particles is the mean likelihood of
/// the scan over the predicted particles. The evidence for anywhere else assumes that the scan fits
/// its true pose about as well as the last scans fitted theirs, divided by the number of distinct
/// poses in the map.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Suspicion {
    settings: SuspicionSettings,
    usual: f64,
    /// The same over the last updates, good and bad.
    recent: f64,
    expected: f64,
    min: f64,
    /// Tolerated drop of the recent evidence below the expected one \[nats per beam\].
    tolerance: f64,
    /// ln(number of distinct poses in the map).
    log_poses: f64,
    /// ln(P(elsewhere) / P(here)).
    log_odds: f64,
    pause: u32,
    waiting: u32,
}

/// Share by which the recent evidence follows each update.
const RECENT: f64 = 0.1;

/// Odds beyond e^10 to either side would take too long to turn.
const MAX_LOG_ODDS: f64 = 10.0;

impl Suspicion {
    /// The robot is at its particles, in a map with `area` \[m^2\] of free space.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`], see [`SuspicionSettings::check`].
    pub fn new(settings: SuspicionSettings, usual: UsualEvidence, area: f64) -> Result<Self> {
        settings.check()?;
        positive("free area [m^2]", area)?;
        let poses = (area * std::f64::consts::TAU / settings.place).max(1.0);
        let UsualEvidence { expected, min } = usual;
        Ok(Suspicion {
            settings,
            usual: expected,
            recent: expected,
            expected,
            min,
            tolerance: 0.6 * (expected - min),
            log_poses: poses.ln(),
            log_odds: -MAX_LOG_ODDS,
            pause: 1,
            waiting: 0,
        })
    }

    /// Updates with a scan: `log_evidence` is the logarithm of its mean likelihood over the
    /// predicted particles, as that of `beams` independent beams. Returns the probability of being
    /// elsewhere.
    pub fn update(&mut self, log_evidence: f64, beams: f64) -> f64 {
        self.waiting = self.waiting.saturating_sub(1);
        if beams <= 0.0 || log_evidence.is_nan() {
            return self.probability();
        }
        let kidnapped = self.probability() + self.settings.rate * (1.0 - self.probability());
        let elsewhere = self.usual.max(self.min) * beams - self.log_poses;
        let odds = (kidnapped / (1.0 - kidnapped)).ln() + elsewhere - log_evidence;
        self.log_odds =
            if odds.is_nan() { self.log_odds } else { odds.clamp(-MAX_LOG_ODDS, MAX_LOG_ODDS) };
        if log_evidence.is_finite() {
            self.recent += RECENT * (log_evidence / beams - self.recent);
        }
        if self.log_odds < 0.0 && log_evidence.is_finite() {
            self.usual += ADAPTATION * (log_evidence / beams - self.usual);
        }
        self.probability()
    }

    /// The probability of being elsewhere.
    pub fn probability(&self) -> f64 {
        1.0 / (1.0 + (-self.log_odds).exp())
    }

    /// Whether to search the map now: the robot may be elsewhere, or scans have not fitted for some
    /// time, and the last search without result is long enough ago.
    pub fn is_alarmed(&self) -> bool {
        let doubtful = self.recent < self.expected - self.tolerance;
        self.waiting == 0 && (doubtful || self.probability() >= ALARM)
    }

    /// After a search without result: the log odds are reset, and the next search is postponed,
    /// each time by twice as many updates. Where the robot is lost anyway, it is not postponed.
    pub fn postpone(&mut self, is_lost: bool) {
        self.log_odds = -MAX_LOG_ODDS;
        if is_lost {
            (self.pause, self.waiting) = (1, 1);
        } else {
            self.waiting = self.pause;
            self.pause = (2 * self.pause).min(MAX_PAUSE);
        }
    }

    /// Resets the log odds: the particles are where the robot was found.
    pub fn clear(&mut self) {
        (self.log_odds, self.pause, self.waiting) = (-MAX_LOG_ODDS, 1, 4);
        self.recent = self.expected;
    }
}

loc_core::settings! {
    /// Settings of [`AugmentedMcl`].
    ///
    /// The values of the literature.
    #[derive(Copy)]
    pub struct AugmentedSettings {
        /// Share by which the long-term average follows each update (`recovery_alpha_slow`).
        pub alpha_slow: f64 = 0.001 => holds(
            "a number above 0 and below alpha_fast",
            |s| s.alpha_slow > 0.0 && s.alpha_slow < s.alpha_fast
        );
        /// Share by which the short-term average does (`recovery_alpha_fast`), above `alpha_slow`.
        pub alpha_fast: f64 = 0.1 => share;
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
    /// [`loc_core::Error::OutOfRange`], see [`AugmentedSettings::check`].
    pub fn new(settings: AugmentedSettings) -> Result<Self> {
        settings.check()?;
        Ok(AugmentedMcl { settings, averages: None })
    }

    /// Updates with `ln(mean likelihood of the particles)`; returns the share of the particle set
    /// to replace by random particles, in \[0, 1\].
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

    /// Resets the averages, after the particles were drawn anew.
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
