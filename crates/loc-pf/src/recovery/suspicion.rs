//! Is the robot where the cloud is, or anywhere else? A Bayes filter over the two.

use crate::Result;
use loc_core::error::{in_range, positive, probability};

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
    /// At the right place at least; below it no experience of a changed world is believed.
    pub least: f64,
}

/// The probability that the robot is not where its cloud is.
///
/// Every scan is evidence for the one and the other. That it is at the cloud: the mean likelihood
/// of the scan over the predicted cloud. That it is anywhere else: a scan fits its own place about
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
    least: f64,
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
        let UsualEvidence { expected, least } = usual;
        Ok(Suspicion {
            settings,
            usual: expected,
            recent: expected,
            expected,
            least,
            tolerance: 0.6 * (expected - least),
            log_places: places.ln(),
            log_odds: -SUREST,
            pause: 1,
            waiting: 0,
        })
    }

    /// Takes in a scan: `log_evidence` is the logarithm of its mean likelihood over the predicted
    /// cloud, as that of `beams` independent beams. Returns the probability of being elsewhere.
    pub fn update(&mut self, log_evidence: f64, beams: f64) -> f64 {
        self.waiting = self.waiting.saturating_sub(1);
        if beams <= 0.0 || log_evidence.is_nan() {
            return self.probability();
        }
        let carried_off = self.probability() + self.settings.rate * (1.0 - self.probability());
        let elsewhere = self.usual.max(self.least) * beams - self.log_places;
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

    /// No suspicion any more: the cloud is where it was suspected to be missing.
    pub fn clear(&mut self) {
        (self.log_odds, self.pause, self.waiting) = (-SUREST, 1, 4);
        self.recent = self.expected;
    }
}
