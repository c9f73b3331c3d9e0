//! Am I lost? The probability that the robot is not where its localizer says.
//!
//! A particle filter that converged at the wrong place looks like one at the right place: a tight
//! particle set, a small covariance. What gives it away are the scans, which the map around the reported
//! pose does not explain. [`LostMonitor`] weighs that up from update to update and states one
//! number, which is meant to be taken at its word: of all the times that it says 0.3, the robot is
//! lost three times in ten. "Lost" means farther than a stated distance or turn from the reported
//! pose ([`Tolerance`]).
//!
//! Two things make a robot lost. The belief may be spread: then its own share near the reported
//! pose ([`Tolerance::support`]) says how likely that is. Or the whole belief may be wrong, which
//! only the scans show. Every scan shifts the log odds of that by
//!
//! `bias - margin_weight m + blocked_weight ln(1 + b / 0.02) + near_weight ln(1 + n / 0.02)`.
//!
//! `m` is how much better the map explains the scan at the reported pose than at the best of some
//! random poses: in a building that looks alike everywhere, a good fit means little. `b` is the
//! share of beams that end behind a wall of the map, the strongest evidence of all: people and new
//! furniture take away from `m` as a wrong pose does, but they make no beam longer. `n` is the
//! share of beams that end near an obstacle but not on it: people stand anywhere, while a filter
//! at a wrong place has chosen the pose there at which the walls fit more or less. From one update
//! to the next, the share [`LostSettings::memory`] of the log odds stays: scans that follow each
//! other tell much the same, and the robot may have been carried off. Together:
//!
//! `P(lost) = 1 - (1 - P(wrong)) support^support_exponent`.
//!
//! This is a Bayes filter on two states (F5) whose evidence is tempered. How much, and what the
//! evidence is worth, is not assumed but fitted to 960 simulated drives by maximum likelihood,
//! which makes the number calibrated instead of just large or small. In buildings and with a laser
//! that the fit has not seen, the mean difference between what is stated and what happens
//! (expected calibration error) is 0.014 over a mixture of surroundings, from static to 40 % of
//! the beams blocked by people. Within one kind of surroundings it is 0.03 to 0.07: where nothing
//! ever changes, even a small misfit means more than stated, among crowds less. On the recording
//! of the Intel laboratory, 96 % of the statements at the reference pose are below 0.05 and more
//! than 99 % of those 1 m beside it are above 0.9.
//!
//! What it cannot know is how often robots get lost where it is used: in 6 of 10 updates of the fit
//! they were. And it cannot tell two places apart that look the same to the laser.
//!
//! ```
//! use loc_pf::confidence::{LostMonitor, LostSettings, ScanFit};
//! let mut monitor = LostMonitor::new(LostSettings::default())?;
//! let elsewhere = &[0.2, 0.35, 0.6, 0.25];
//! let right = ScanFit { here: 0.9, elsewhere, blocked: 0.02, near: 0.02 };
//! let wrong = ScanFit { here: 0.5, elsewhere, blocked: 0.4, near: 0.2 };
//! for _ in 0..5 {
//!     monitor.update(Some(right), 1.0);
//! }
//! assert!(monitor.probability() < 0.05);
//! for _ in 0..5 {
//!     monitor.update(Some(wrong), 1.0);
//! }
//! assert!(monitor.probability() > 0.9);
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod fit;

pub use fit::{ScanFit, ScanRater};

use crate::elementary::{exp, wrap};
use crate::{Particles, Poses, Result};
use loc_core::error::{finite, in_range, non_negative, positive};
use loc_core::{Pose2, angle};
use pulp::{Arch, Simd, WithSimd};

/// Keeps the probability that the belief is wrong, from update to update.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LostMonitor {
    settings: LostSettings,
    /// ln(P(belief wrong) / P(belief right)).
    log_odds: f64,
    /// What was reported last.
    probability: f64,
}

/// Odds beyond e^12 to either side are more than any fit can vouch for.
const SUREST: f64 = 12.0;

impl LostMonitor {
    /// A monitor that does not know whether the start is right: even odds.
    ///
    /// # Errors
    /// Those of [`LostSettings::validate`].
    pub fn new(settings: LostSettings) -> Result<Self> {
        settings.validate()?;
        Ok(LostMonitor { settings, log_odds: 0.0, probability: 0.5 })
    }

    /// The settings.
    pub fn settings(&self) -> &LostSettings {
        &self.settings
    }

    /// Begins anew with the probability that the belief is wrong, for instance after a new start
    /// pose was given. It fades as old scans do.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for what is no probability.
    pub fn restart(&mut self, wrong: f64) -> Result<()> {
        self.probability = loc_core::error::probability("P(start is wrong)", wrong)?;
        self.log_odds = log_odds(wrong);
        Ok(())
    }

    /// The probability of being lost, after the last update.
    pub fn probability(&self) -> f64 {
        self.probability
    }

    /// The same as log odds, `ln(P / (1 - P))`.
    pub fn log_odds(&self) -> f64 {
        log_odds(self.probability)
    }

    /// Takes in an update of the filter and returns the probability of being lost: how the scan
    /// fits (`None` for an update without one), and the share of the belief near the reported pose
    /// ([`Tolerance::support`]).
    ///
    /// A fit that is not made of numbers counts as none, a support that is no number as 0.
    pub fn update(&mut self, scan: Option<ScanFit<'_>>, support: f64) -> f64 {
        let shift = scan.map(|scan| self.settings.shift(&scan)).filter(|shift| shift.is_finite());
        if let Some(shift) = shift {
            let odds = self.settings.memory * self.log_odds + shift;
            self.log_odds = odds.clamp(-SUREST, SUREST);
        }
        let support = if support > 0.0 { support.min(1.0) } else { 0.0 };
        let right = 1.0 / (1.0 + self.log_odds.exp());
        self.probability = 1.0 - right * support.powf(self.settings.support_exponent);
        self.probability
    }
}

fn log_odds(probability: f64) -> f64 {
    (probability / (1.0 - probability)).ln().clamp(-SUREST, SUREST)
}

// What "lost" means, and the constants of the fit.

/// Settings of a [`LostMonitor`](LostMonitor).
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

// How far off a pose may be before it counts as lost.

/// The largest error of a reported pose that is not yet called lost.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct Tolerance {
    /// Of the position \[m\].
    pub distance: f64,
    /// Of the heading \[rad\].
    pub turn: f64,
}

impl Default for Tolerance {
    /// 0.5 m and 15 degrees.
    fn default() -> Self {
        Tolerance { distance: 0.5, turn: 15_f64.to_radians() }
    }
}

impl Tolerance {
    /// Checks both numbers.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] naming the first that is not positive.
    pub fn validate(&self) -> Result<()> {
        positive("tolerance of the position [m]", self.distance)?;
        positive("tolerance of the heading [rad]", self.turn)?;
        Ok(())
    }

    /// Whether a pose is as close to the true one as this asks for.
    pub fn holds(&self, reported: Pose2, truth: Pose2) -> bool {
        let (x, y) = (reported.x - truth.x, reported.y - truth.y);
        x * x + y * y <= self.distance * self.distance
            && angle::difference(reported.theta, truth.theta).abs() <= self.turn
    }

    /// Share of the belief's weight within this tolerance of the reported pose: the probability
    /// that the robot is not lost, as far as the particle set itself knows. The weights must be
    /// normalised; 0 for a particle set without particles.
    pub fn support(&self, particles: &Particles, reported: Pose2) -> f64 {
        Arch::new().dispatch(Support { tolerance: *self, particles, reported })
    }
}

/// Numbers added up side by side.
const LANES: usize = 8;

struct Support<'a> {
    tolerance: Tolerance,
    particles: &'a Particles,
    reported: Pose2,
}

impl WithSimd for Support<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let Support { tolerance: Tolerance { distance, turn }, particles, reported } = self;
        let Poses { x, y, theta } = particles.poses();
        let mut sums = [0.0; LANES];
        let chunks = x.chunks(LANES).zip(y.chunks(LANES)).zip(theta.chunks(LANES));
        for (((x, y), theta), weights) in chunks.zip(particles.log_weights().chunks(LANES)) {
            let poses = x.iter().zip(y).zip(theta).zip(weights);
            for (sum, (((x, y), theta), weight)) in sums.iter_mut().zip(poses) {
                let (dx, dy) = (x - reported.x, y - reported.y);
                let near = (dx * dx + dy * dy <= distance * distance)
                    & (wrap(theta - reported.theta).abs() <= turn);
                *sum += if near { exp(*weight) } else { 0.0 };
            }
        }
        sums.iter().sum::<f64>().min(1.0)
    }
}
