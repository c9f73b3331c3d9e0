//! How much later than its stamp a robot was where its odometry says.
//!
//! Odometry and scans come from two computers or two drivers, each with a clock and a queue of its
//! own. Stamps that are off by a tenth of a second do no harm to a robot that drives straight on,
//! but when it starts to turn at 1 rad/s the two disagree by 6 degrees. The scans themselves show
//! it: matching each with the one before tells how far the robot has turned, from walls alone and
//! without a map. [`DelayEstimator`] finds the delay at which the odometry has turned as far, over
//! all pairs of scans with a turn that changes; where nothing but the stamps is wrong, this is
//! known to a few milliseconds.
//!
//! A scan that takes a tenth of a second is matched as if it were made at once, which is true of
//! its middle: half the time of a sweep after the stamp of its first beam is part of the answer.
//!
//! ```
//! use loc_core::{Pose2, random::stream};
//! use loc_maps::RayCaster;
//! use loc_maps::worlds::{self, WorldSettings};
//! use loc_pf::delay::{DelayEstimator, DelaySettings};
//! use loc_sensors::laser::{LaserScanner, LaserSpec};
//! let map = worlds::office(&WorldSettings { width: 300, height: 300, ..Default::default() })?.grid;
//! let (walls, laser) = (RayCaster::new(&map), LaserScanner::new(LaserSpec::sick_lms100())?);
//! let mut rng = stream(1, "laser");
//! // The robot swings to and fro; its odometry reports every pose 0.1 s late.
//! let pose = |t: f64| Pose2::new(7.5, 7.5, 0.8 * (1.5 * t).sin());
//! let mut estimator = DelayEstimator::new(DelaySettings::default())?;
//! for step in 0..200 {
//!     let t = 0.05 * f64::from(step);
//!     estimator.odometry(t + 0.1, pose(t));
//!     if step % 2 == 0 {
//!         estimator.scan(t, &laser.scan(&walls, pose(t), &mut rng), Pose2::IDENTITY);
//!     }
//! }
//! let found = estimator.estimate().ok_or("the robot has not turned")?;
//! // Stamps have to go back by 0.1 s.
//! assert!((found.delay + 0.1).abs() < 0.01 && found.sigma < 0.01, "{found:?}");
//! assert!(found.is_significant());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod fit;
mod outline;
mod settings;
mod trace;

pub use settings::DelaySettings;

use crate::Result;
use loc_core::Pose2;
use loc_sensors::laser::LaserScan;
use outline::Outline;
use std::collections::VecDeque;
use trace::Trace;

/// Gathers odometry and scans, in the order of their stamps each, and finds the delay between them.
#[derive(Debug)]
pub struct DelayEstimator {
    settings: DelaySettings,
    trace: Trace,
    /// Scans whose odometry is not there yet.
    waiting: VecDeque<Stop>,
    before: Option<Stop>,
    turns: Vec<Turn>,
}

/// A scan at a time.
#[derive(Debug)]
struct Stop {
    stamp: f64,
    outline: Outline,
    mounting: Pose2,
}

/// How far the robot has turned by two scans.
#[derive(Debug, Clone, Copy)]
struct Turn {
    from: f64,
    to: f64,
    /// Counter-clockwise \[rad\].
    angle: f64,
}

/// A delay with what is known about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DelayEstimate {
    /// What has to be added to the stamps of the odometry \[s\]: negative for an odometry that
    /// comes late.
    pub delay: f64,
    /// Its standard deviation \[s\].
    pub sigma: f64,
    /// How far the robot turned by its scans for each radian of its odometry.
    pub scale: f64,
    /// Pairs of scans that it comes from.
    pub pairs: usize,
}

impl DelayEstimate {
    /// A delay below this changes nothing \[s\].
    pub const MIN: f64 = 0.01;

    /// Whether there is a delay: at least [`DelayEstimate::MIN`], and three standard deviations.
    pub fn is_significant(&self) -> bool {
        self.delay.abs() >= DelayEstimate::MIN.max(3.0 * self.sigma)
    }
}

impl DelayEstimator {
    /// An estimator that knows nothing yet.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for settings that are none.
    pub fn new(settings: DelaySettings) -> Result<Self> {
        settings.validate()?;
        let (trace, waiting) = (Trace::default(), VecDeque::new());
        Ok(DelayEstimator { settings, trace, waiting, before: None, turns: Vec::new() })
    }

    /// Takes in a pose of the odometry \[s\]. What is not finite or not after the one before is
    /// passed over.
    pub fn odometry(&mut self, stamp: f64, pose: Pose2) {
        self.trace.push(stamp, pose);
        while self.waiting.front().is_some_and(|scan| stamp >= scan.stamp + self.settings.longest) {
            if let Some(scan) = self.waiting.pop_front() {
                self.pair(scan);
            }
        }
    }

    /// Takes in a scan \[s\] of a laser at `mounting` (`base_from_laser`). Scans that cannot be
    /// any and those not after the one before are passed over.
    pub fn scan(&mut self, stamp: f64, scan: &LaserScan, mounting: Pose2) {
        let last = self.waiting.back().or(self.before.as_ref()).map(|stop| stop.stamp);
        let is_soon = last.is_some_and(|last| stamp < last + self.settings.shortest_step);
        if !stamp.is_finite() || !mounting.is_finite() || is_soon || scan.check().is_err() {
            return;
        }
        let outline = Outline::of(scan, self.settings.points);
        self.waiting.push_back(Stop { stamp, outline, mounting });
    }

    /// Whether there are as many pairs of scans as the settings ask for.
    pub fn has_enough(&self) -> bool {
        self.turns.len() >= self.settings.pairs
    }

    /// Matches a scan with the one before, where the odometry turns by a rate that changes
    /// thereabouts: nothing else tells a delay.
    fn pair(&mut self, scan: Stop) {
        let before = self.before.replace(scan);
        let (Some(before), Some(scan)) = (before, &self.before) else { return };
        let (from, to) = (before.stamp, scan.stamp);
        if self.has_enough() || to - from > self.settings.longest_step {
            return;
        }
        let around = (from - self.settings.longest, to + self.settings.longest);
        let Some(change) = self.trace.change_of_rate(around.0, around.1) else { return };
        let step = self.trace.pose(from).zip(self.trace.pose(to));
        let Some((first, second)) = step.filter(|_| change >= self.settings.change_of_rate) else {
            return;
        };
        let of_laser = before.mounting.inverse() * first.between(second) * scan.mounting;
        let turned = scan.outline.turn_since(&before.outline, of_laser);
        // A laser that is turned on its robot between two scans is none that this can follow.
        let angle = turned.map(|turned| turned + before.mounting.theta - scan.mounting.theta);
        self.turns.extend(angle.map(|angle| Turn { from, to, angle }));
    }

    /// The delay by what has come in so far; `None` while too few scans with a changing turn could
    /// be matched.
    pub fn estimate(&self) -> Option<DelayEstimate> {
        fit::fit(&self.turns, &self.trace, self.settings.longest)
    }
}
