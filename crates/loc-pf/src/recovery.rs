//! Finding the robot again after it was carried off, or lost for another reason (A3).
//!
//! A particle set that follows one place never looks at another by itself. [`AugmentedMcl`] replaces a
//! share of it by particles from all over the map when scans fit worse than they used to.
//! [`Suspicion`] is sharper: it weighs the evidence that the robot is where the particle set says against
//! that of its being anywhere else, as a Bayes filter over these two, and calls for a global search
//! only when the second gains ground.
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
use loc_core::error::{in_range, positive, probability};

// Is the robot where the particle set is, or anywhere else? A Bayes filter over the two.

/// Settings of [`Suspicion`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct SuspicionSettings {
    /// Probability that the robot is carried off, or lost, between two updates.
    pub rate: f64,
    /// From this probability of being elsewhere on, a search is called for.
    pub alarm: f64,
    /// Share by which the usual evidence follows each update.
    pub adaptation: f64,
    /// Extent of a place in the space of poses \[m^2 rad\]: about what a sharp scan leaves.
    pub place: f64,
    /// The most updates to wait after a search that found nothing better.
    pub longest_pause: u32,
}

impl Default for SuspicionSettings {
    fn default() -> Self {
        SuspicionSettings {
            rate: 1e-3,
            alarm: 0.1,
            adaptation: 0.05,
            place: 0.01,
            longest_pause: 16,
        }
    }
}

impl SuspicionSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] naming the first that is not allowed.
    pub fn validate(&self) -> Result<()> {
        probability("rate of kidnappings", self.rate)?;
        let share = |v: f64| v > 0.0 && v < 1.0;
        let expected = "a probability above 0 and below 1";
        in_range("alarm of the suspicion", expected, self.alarm, share)?;
        probability("adaptation of the usual evidence", self.adaptation)?;
        positive("extent of a place [m^2 rad]", self.place)?;
        Ok(())
    }
}

/// How well a scan fits its place, in nats a beam: what is usual, and what chance achieves.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct UsualEvidence {
    /// At the right place, before any experience.
    pub expected: f64,
    /// At the right place at min; below it no experience of a changed world is believed.
    pub min: f64,
}

/// The probability that the robot is not where its particle set is.
///
/// Every scan is evidence for the one and the other. That it is at the particle set: the mean likelihood
/// of the scan over the predicted particle set. That it is anywhere else: a scan fits its own place about
/// as well as the last ones fitted theirs, but there are many places, and their number counts
/// against each of them.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Suspicion {
    settings: SuspicionSettings,
    usual: f64,
    /// The same over the last updates, good and bad.
    recent: f64,
    expected: f64,
    min: f64,
    /// How far below the usual evidence that of a new place may be, in nats a beam.
    tolerance: f64,
    /// ln(number of places in the map).
    log_places: f64,
    /// ln(P(elsewhere) / P(here)).
    log_odds: f64,
    pause: u32,
    waiting: u32,
}

/// Share by which the recent evidence follows each update.
const RECENT: f64 = 0.1;

/// Odds beyond e^10 to either side would take too long to turn.
const SUREST: f64 = 10.0;

impl Suspicion {
    /// No suspicion yet, in a map with `area` \[m^2\] of free space.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`], see [`SuspicionSettings::validate`].
    pub fn new(settings: SuspicionSettings, usual: UsualEvidence, area: f64) -> Result<Self> {
        settings.validate()?;
        positive("free area [m^2]", area)?;
        let places = (area * std::f64::consts::TAU / settings.place).max(1.0);
        let UsualEvidence { expected, min } = usual;
        Ok(Suspicion {
            settings,
            usual: expected,
            recent: expected,
            expected,
            min,
            tolerance: 0.6 * (expected - min),
            log_places: places.ln(),
            log_odds: -SUREST,
            pause: 1,
            waiting: 0,
        })
    }

    /// Takes in a scan: `log_evidence` is the logarithm of its mean likelihood over the predicted
    /// particle set, as that of `beams` independent beams. Returns the probability of being elsewhere.
    pub fn update(&mut self, log_evidence: f64, beams: f64) -> f64 {
        self.waiting = self.waiting.saturating_sub(1);
        if beams <= 0.0 || log_evidence.is_nan() {
            return self.probability();
        }
        let carried_off = self.probability() + self.settings.rate * (1.0 - self.probability());
        let elsewhere = self.usual.max(self.min) * beams - self.log_places;
        let odds = (carried_off / (1.0 - carried_off)).ln() + elsewhere - log_evidence;
        self.log_odds = if odds.is_nan() { self.log_odds } else { odds.clamp(-SUREST, SUREST) };
        if log_evidence.is_finite() {
            self.recent += RECENT * (log_evidence / beams - self.recent);
        }
        if self.log_odds < 0.0 && log_evidence.is_finite() {
            self.usual += self.settings.adaptation * (log_evidence / beams - self.usual);
        }
        self.probability()
    }

    /// The probability of being elsewhere.
    pub fn probability(&self) -> f64 {
        1.0 / (1.0 + (-self.log_odds).exp())
    }

    /// Whether to search the map now: the robot may be elsewhere, or scans have not fitted for some
    /// time, and the last search in vain is long enough ago.
    pub fn is_alarmed(&self) -> bool {
        let doubtful = self.recent < self.expected - self.tolerance;
        self.waiting == 0 && (doubtful || self.probability() >= self.settings.alarm)
    }

    /// A search, or what it found, came to nothing: the suspicion is dropped, and the next search
    /// waits, longer from time to time. Where the robot is lost in any case, it does not wait.
    pub fn put_off(&mut self, is_lost: bool) {
        self.log_odds = -SUREST;
        if is_lost {
            (self.pause, self.waiting) = (1, 1);
        } else {
            self.waiting = self.pause;
            self.pause = (2 * self.pause).min(self.settings.longest_pause);
        }
    }

    /// No suspicion any more: the particle set is where it was suspected to be missing.
    pub fn clear(&mut self) {
        (self.log_odds, self.pause, self.waiting) = (-SUREST, 1, 4);
        self.recent = self.expected;
    }
}

// Augmented Monte Carlo localization: how many random particles the last scans call for.

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

    /// Takes in `ln(mean likelihood of the particles)`; returns the share of the particle set to replace
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

    /// Forgets the past, after the particle set was spread anew.
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
