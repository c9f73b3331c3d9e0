//! Delay of odometry against scans: how much its stamps are late or early.
//!
//! Odometry and scans come from two computers or two drivers, each with a clock and a queue of its
//! own. An error of the stamps of a tenth of a second is harmless while a robot drives straight,
//! but when it starts to turn at 1 rad/s the two disagree by 6 degrees. The scans determine the
//! delay: matching each with the one before measures the turn of the robot, from walls alone and
//! without a map. [`DelayEstimator`] finds the delay at which the odometry has turned as far, over
//! all pairs of scans with a turn that changes; where only the stamps are wrong, it is accurate to
//! a few milliseconds.
//!
//! A scan that takes a tenth of a second is matched as if it were instantaneous, at the time of
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

mod outline;

use crate::Result;
use loc_core::Pose2;
use loc_core::error::positive;
use loc_sensors::laser::LaserScan;
use nalgebra::{Matrix2, Vector2};
use outline::{Outline, Trace};
use std::collections::VecDeque;

/// Collects odometry and scans, each in the order of their stamps, and finds the delay between
/// them.
#[derive(Debug)]
pub struct DelayEstimator {
    settings: DelaySettings,
    trace: Trace,
    /// Scans that wait for odometry.
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

/// A delay with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DelayEstimate {
    /// What has to be added to the stamps of the odometry \[s\]: negative for an odometry that
    /// comes late.
    pub delay: f64,
    /// Its standard deviation \[s\].
    pub sigma: f64,
    /// How far the robot turned by its scans for each radian of its odometry.
    pub scale: f64,
    /// Number of pairs of scans used.
    pub pairs: usize,
}

impl DelayEstimate {
    /// A smaller delay is ignored \[s\].
    pub const MIN: f64 = 0.01;

    /// Whether there is a delay: at least [`DelayEstimate::MIN`], and three standard deviations.
    pub fn is_significant(&self) -> bool {
        self.delay.abs() >= DelayEstimate::MIN.max(3.0 * self.sigma)
    }
}

impl DelayEstimator {
    /// An estimator without data.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for settings out of range.
    pub fn new(settings: DelaySettings) -> Result<Self> {
        settings.check()?;
        let (trace, waiting) = (Trace::default(), VecDeque::new());
        Ok(DelayEstimator { settings, trace, waiting, before: None, turns: Vec::new() })
    }

    /// Adds a pose of the odometry at a time \[s\]. Poses that are not finite or not after the one
    /// before are ignored.
    pub fn odometry(&mut self, stamp: f64, pose: Pose2) {
        self.trace.push(stamp, pose);
        while self.waiting.front().is_some_and(|scan| stamp >= scan.stamp + self.settings.longest) {
            if let Some(scan) = self.waiting.pop_front() {
                self.pair(scan);
            }
        }
    }

    /// Adds a scan at a time \[s\] of a laser at `mounting` (`base_from_laser`). Scans that are not
    /// valid or not after the one before are ignored.
    pub fn scan(&mut self, stamp: f64, scan: &LaserScan, mounting: Pose2) {
        let last = self.waiting.back().or(self.before.as_ref()).map(|stop| stop.stamp);
        let is_soon = last.is_some_and(|last| stamp < last + self.settings.shortest_step);
        if !stamp.is_finite() || !mounting.is_finite() || is_soon || scan.check().is_err() {
            return;
        }
        let outline = Outline::of(scan, self.settings.points);
        self.waiting.push_back(Stop { stamp, outline, mounting });
    }

    /// Whether the maximum number of pairs of scans is reached.
    pub fn has_enough(&self) -> bool {
        self.turns.len() >= self.settings.pairs
    }

    /// Matches a scan with the one before, where the rate of turn of the odometry
    /// changes nearby: only such pairs determine a delay.
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

    /// The delay from the data so far; `None` while too few scans with a changing turn could
    /// be matched.
    pub fn estimate(&self) -> Option<DelayEstimate> {
        fit(&self.turns, &self.trace, self.settings.longest)
    }
}

/// Settings of [`DelayEstimator`]; the defaults suit robots that turn at
/// walking pace and scanners of 5 Hz and more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DelaySettings {
    /// Maximum delay, either way \[s\].
    pub longest: f64,
    /// Scans sooner after the one before are ignored \[s\].
    pub shortest_step: f64,
    /// Scans later after the one before are not matched with it \[s\].
    pub longest_step: f64,
    /// Minimum change of the rate of turn around a pair of scans for matching them
    /// \[rad/s\].
    pub change_of_rate: f64,
    /// Maximum number of points of a scan.
    pub points: usize,
    /// Maximum number of pairs of scans.
    pub pairs: usize,
}

impl Default for DelaySettings {
    fn default() -> Self {
        DelaySettings {
            longest: 0.5,
            shortest_step: 0.08,
            longest_step: 0.5,
            change_of_rate: 0.1,
            points: 180,
            pairs: 400,
        }
    }
}

impl DelaySettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] naming the first that is not allowed.
    pub fn check(&self) -> loc_core::Result<()> {
        positive("longest delay [s]", self.longest)?;
        positive("shortest step between scans [s]", self.shortest_step)?;
        positive("longest step between scans [s]", self.longest_step)?;
        positive("change of the rate of turn [rad/s]", self.change_of_rate)?;
        positive("points of a scan", self.points as f64)?;
        positive("pairs of scans", self.pairs as f64)?;
        Ok(())
    }
}

/// Minimum number of pairs of scans.
const MIN_PAIRS: usize = 10;

/// Steps of the search \[s\].
const STEP: f64 = 0.01;

/// How far a turn by two scans and one by odometry differ where the delay is right \[rad\].
const NOISE: f64 = 0.005;

/// Bounds of the odometry's scale.
const SCALES: [f64; 2] = [0.7, 1.4];

/// Uncertainty from stamps and interpolation \[s\].
const FLOOR: f64 = 0.002;

fn fit(turns: &[Turn], trace: &Trace, longest: f64) -> Option<DelayEstimate> {
    let covered = |turn: &&Turn| {
        let turned = |delay: f64| trace.turn(turn.from - delay, turn.to - delay);
        turned(longest).is_some() && turned(-longest).is_some()
    };
    let turns: Vec<Turn> = turns.iter().filter(covered).copied().collect();
    if turns.len() < MIN_PAIRS {
        return None;
    }
    let count = (2.0 * longest / STEP).round() as i32;
    let delays = (0..=count).map(|k| -longest + f64::from(k) * STEP);
    let rated = delays.filter_map(|delay| Some((delay, cost(&turns, trace, delay)?)));
    let (coarse, _) = rated.min_by(|a, b| a.1.total_cmp(&b.1))?;
    refine(&turns, trace, coarse)
}

/// The robust cost of a delay, at the scale that suits it best.
fn cost(turns: &[Turn], trace: &Trace, delay: f64) -> Option<f64> {
    let odometry: Option<Vec<f64>> =
        turns.iter().map(|turn| trace.turn(turn.from - delay, turn.to - delay)).collect();
    let odometry = odometry?;
    let both = || turns.iter().zip(&odometry);
    let product: f64 = both().map(|(turn, odometry)| turn.angle * odometry).sum();
    let square: f64 = odometry.iter().map(|odometry| odometry * odometry).sum();
    let scale = if square > 0.0 { product / square } else { 1.0 };
    let scale = scale.clamp(SCALES[0], SCALES[1]);
    let errors = both().map(|(turn, odometry)| turn.angle - scale * odometry);
    Some(errors.map(|error| (error / NOISE).powi(2).ln_1p()).sum())
}

/// Delay and scale by weighted least squares from the best of the search, with the variance that
/// the errors themselves show.
fn refine(turns: &[Turn], trace: &Trace, coarse: f64) -> Option<DelayEstimate> {
    let mut state = Vector2::new(coarse, 1.0);
    let (mut information, mut scatter) = (Matrix2::zeros(), Matrix2::zeros());
    for _ in 0..20 {
        let mut gradient = Vector2::zeros();
        (information, scatter) = (Matrix2::zeros(), Matrix2::zeros());
        for turn in turns {
            let turned = |delay: f64| trace.turn(turn.from - delay, turn.to - delay);
            let (delay, scale) = (state.x, state.y);
            let Some(odometry) = turned(delay) else { continue };
            let around = turned(delay + STEP).zip(turned(delay - STEP));
            let Some((later, sooner)) = around else { continue };
            let jacobian = Vector2::new(scale * (later - sooner) / (2.0 * STEP), odometry);
            let error = turn.angle - scale * odometry;
            let weight = 1.0 / (1.0 + (error / NOISE).powi(2));
            information += weight * jacobian * jacobian.transpose();
            scatter += (weight * error).powi(2) * jacobian * jacobian.transpose();
            gradient += weight * error * jacobian;
        }
        let step = information.cholesky()?.solve(&gradient);
        let bounded = step.x.clamp(-STEP, STEP);
        state.x = (state.x + bounded).clamp(coarse - STEP, coarse + STEP);
        state.y = (state.y + step.y).clamp(SCALES[0], SCALES[1]);
        if step.x.abs() < 1e-6 {
            break;
        }
    }
    let inverse = information.try_inverse()?;
    let variance = (inverse * scatter * inverse).m11;
    let sigma = (variance + FLOOR * FLOOR).sqrt();
    let (delay, scale, pairs) = (state.x, state.y, turns.len());
    sigma.is_finite().then_some(DelayEstimate { delay, sigma, scale, pairs })
}
