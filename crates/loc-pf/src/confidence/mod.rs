//! The probability of being lost: that the robot is not at the estimated pose.
//!
//! A particle filter that converged to a wrong pose resembles one at the true pose: a compact
//! particle set, a small covariance. The difference is in the scans, which the map around the
//! reported pose does not explain. [`LostMonitor`] accumulates that evidence from update to update
//! in one calibrated probability: of all updates with 0.3, the robot is lost in three of ten.
//! "Lost" means farther than a stated distance or turn from the reported pose ([`Tolerance`]).
//!
//! There are two cases. The belief may be spread: then its own share near the reported pose
//! ([`Tolerance::support`]) gives the probability. Or the whole belief may be wrong, which only the
//! scans show. Every scan shifts the log odds of that by
//!
//! `bias - margin_weight m + blocked_weight ln(1 + b / 0.02) + near_weight ln(1 + n / 0.02)`.
//!
//! `m` is how much better the map explains the scan at the reported pose than at the best of some
//! random poses: in a repetitive building a good fit is weak evidence. `b` is the share of beams
//! that end behind a wall of the map, the strongest evidence of all: people and new furniture
//! reduce `m` as a wrong pose does, but they make no beam longer. `n` is the share of beams that
//! end near an obstacle but not on it: people stand anywhere, while a filter at a wrong pose has
//! converged to one at which the walls fit approximately. From one update to the next, the share
//! [`LostSettings::memory`] of the log odds stays: successive scans are correlated, and the robot
//! may have been kidnapped. Together:
//!
//! `P(lost) = 1 - (1 - P(wrong)) support^support_exponent`.
//!
//! This is a Bayes filter on two states (F5) whose evidence is tempered. The exponents and weights
//! are fitted to 960 simulated drives by maximum likelihood, which calibrates the probability. In
//! buildings and with a laser that the fit has not seen, the mean difference between what is stated
//! and what happens (expected calibration error) is 0.014 over a mixture of surroundings, from
//! static to 40 % of the beams blocked by people. Within one kind of surroundings it is 0.03 to
//! 0.07: where nothing ever changes, even a small misfit means more than stated, among crowds less.
//! On the recording of the Intel laboratory, 96 % of the statements at the reference pose are below
//! 0.05 and more than 99 % of those 1 m beside it are above 0.9.
//!
//! The prior rate of being lost is that of the fit: 6 of 10 updates. Two poses with the same scans
//! cannot be distinguished.
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
use loc_core::{Pose2, angle};
use pulp::{Arch, Simd, WithSimd};

/// The probability that the belief is wrong, updated with every scan.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LostMonitor {
    settings: LostSettings,
    /// ln(P(belief wrong) / P(belief right)).
    log_odds: f64,
    /// The probability reported last.
    probability: f64,
}

/// Maximum log odds, either way.
const SUREST: f64 = 12.0;

impl LostMonitor {
    /// A monitor with even odds that the start is right.
    ///
    /// # Errors
    /// Those of [`LostSettings::check`].
    pub fn new(settings: LostSettings) -> Result<Self> {
        settings.check()?;
        Ok(LostMonitor { settings, log_odds: 0.0, probability: 0.5 })
    }

    /// The settings.
    pub fn settings(&self) -> &LostSettings {
        &self.settings
    }

    /// Restarts with a probability that the belief is wrong, for instance after a new initial pose.
    /// Its influence decays as that of old scans.
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

    /// Processes an update of the filter and returns the probability of being lost: how the scan
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

loc_core::settings! {
    /// Settings of a [`LostMonitor`].
    ///
    /// The constants after `tolerance` belong together: they are the fit of the test
    /// `lost::fit_the_constants` to drives through simulated offices.
    #[derive(Copy)]
    pub struct LostSettings {
        /// Maximum error of a reported pose that is not lost.
        pub tolerance: Tolerance = Tolerance::default() => check;
        /// Share of the log odds that stays from one update to the next.
        pub memory: f64 = 0.625 => holds(
            "from 0 to below 1",
            |lost| (0.0..1.0).contains(&lost.memory)
        );
        /// Shift of the log odds by a scan that fits no better than at the best of the random
        /// poses, with no beam blocked or near.
        pub bias: f64 = -2.478 => finite;
        /// Weight of the margin over the best of the random poses.
        pub margin_weight: f64 = 2.544 => non_negative;
        /// Weight of blocked beams.
        pub blocked_weight: f64 = 1.246 => non_negative;
        /// Weight of beams that end near obstacles.
        pub near_weight: f64 = 0.4545 => non_negative;
        /// Exponent of the belief's own support: 0 for no influence.
        pub support_exponent: f64 = 1.089 => non_negative;
    }
}

/// The share of beams at which their weight begins to count by the logarithm: a beam of 50 may go
/// astray anywhere.
const STRAY: f64 = 0.02;

impl LostSettings {
    /// By how much a scan shifts the log odds of a wrong belief, see [`crate::confidence`].
    pub fn shift(&self, scan: &ScanFit<'_>) -> f64 {
        let [blocked, near] = [scan.blocked, scan.near].map(|share| (share / STRAY).ln_1p());
        self.bias - self.margin_weight * scan.margin()
            + self.blocked_weight * blocked
            + self.near_weight * near
    }
}

loc_core::settings! {
    /// Maximum error of a reported pose that does not count as lost.
    ///
    /// 0.5 m and 15 degrees.
    #[derive(Copy)]
    pub struct Tolerance {
        /// Of the position \[m\].
        pub distance: f64 = 0.5 => positive;
        /// Of the heading \[rad\].
        #[serde(with = "loc_core::settings::angle")]
        pub turn: f64 = 15_f64.to_radians() => positive;
    }
}

impl Tolerance {
    /// Whether a pose is within the tolerance of the true one.
    pub fn holds(&self, reported: Pose2, truth: Pose2) -> bool {
        let (x, y) = (reported.x - truth.x, reported.y - truth.y);
        x * x + y * y <= self.distance * self.distance
            && angle::difference(reported.theta, truth.theta).abs() <= self.turn
    }

    /// Share of the belief's weight within this tolerance of the reported pose: the probability
    /// that the robot is not lost if the particles are right. The weights must be
    /// normalised; 0 without particles.
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
