//! Markov localization of a robot with a laser: a grid over (x, y, heading) (K1).
//!
//! The free part of a map is divided into squares and the full turn into sectors; each pair of them
//! is a cell with a probability. A motion shifts each layer of one heading by the displacement of a
//! robot with this heading, and blurs it by the errors of the odometry. A scan multiplies
//! each cell by how likely it is there: P(x | s) = alpha P(s | x) P(x) (Burgard, Fox, Hennig and
//! Schmidt, "Estimating the absolute position of a mobile robot using position probability grids",
//! 1996; Fox, Burgard and Thrun, "Markov localization for mobile robots in dynamic environments",
//! 1999).
//!
//! A cell stands for all of its poses. Its likelihood is therefore the mean over them, taken over
//! the free map cells of the square and several headings of the sector, each a product of lookups
//! in the [likelihood field](loc_maps::likelihood_field). Two things keep that cheap:
//!
//! - **Bounds.** For each cell an upper bound of the likelihood of the scan in any of its poses is computed
//!   first, from maxima of the field that are computed once. Cells which even so have together no
//!   more than the share `negligible` of the result are passed over. The error of the result is
//!   at most that; it is reported as [`GridReport::passed_over`].
//! - **A fine grid** of 0.04 m and half a degree, which follows the most likely place (Burgard,
//!   Derr, Fox and Cremers, "Integrating global position estimation and position tracking for
//!   mobile robots: the dynamic Markov localization approach", 1998). Both grids share one
//!   probability of 1: what is near the most likely place is kept in the fine grid, all else in the
//!   coarse one.
//!
//! A kidnapped robot is relocalized because no place is ever ruled out: with each motion the share
//! `kidnap_rate` is spread evenly over the map (K1). A scan that does not fit where the
//! robot was, but fits elsewhere, moves the belief there in one update. Where odometry has failed (slip,
//! a push), the coarse grid still covers the robot: a share of each motion has a standard deviation as large as
//! its length.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_core::random::stream;
//! use loc_filters::histogram::{GridLocalizer, GridSettings};
//! use loc_maps::worlds::{self, WorldSettings};
//! use loc_sensors::laser::{LaserScanner, LaserSpec};
//! let map = worlds::office(&WorldSettings { width: 200, height: 200, ..Default::default() })?.grid;
//! let mut localizer = GridLocalizer::new(&map, GridSettings::default())?;
//! let laser = LaserScanner::new(LaserSpec::sick_lms100())?;
//! let robot = Pose2::new(3.0, 2.5, 1.2);
//! let scan = laser.scan(&map, robot, &mut stream(1, "sensor"));
//! localizer.update(Pose2::IDENTITY, &scan, Pose2::IDENTITY)?;
//! assert!(localizer.belief().pose().distance(robot) < 0.05 && localizer.certainty() > 0.9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod belief;
mod correct;
mod field;
mod settings;
mod space;
mod stack;
#[cfg(test)]
mod tests;
mod window;

pub use settings::{FineSettings, GridSettings};

use crate::Result;
use crate::localizer::{Decision, Estimate, GridBelief, Hypothesis, Localizer, Outcome};
use belief::{Belief, Peak};
use correct::{Scan, Sensor};
use loc_core::error::finite;
use loc_core::motion::DrivenPath;
use loc_core::{Gaussian, Pose2};
use loc_maps::OccupancyGrid;
use loc_maps::grid::GridFrame;
use loc_sensors::event::{Control, Measurement};
use loc_sensors::laser::LaserScan;
use nalgebra::{Matrix3, Vector3};
use space::PoseSpace;
use stack::Sums;
use window::Window;

// A robot with a laser, followed on the grid.

/// The number of hypotheses that are reported.
const HYPOTHESES: usize = 5;

/// A robot followed by a histogram over all of its poses.
#[derive(Debug, Clone)]
pub struct GridLocalizer {
    settings: GridSettings,
    space: PoseSpace,
    sensor: Sensor,
    belief: Belief,
    path: Option<DrivenPath>,
    /// Whether a scan was used since the start.
    has_scan: bool,
    /// The most likely place at the last update.
    best: BestPose,
    /// Whether the last input changed the belief.
    has_changed: bool,
}

/// The most likely place.
#[derive(Debug, Clone, Copy, PartialEq)]
struct BestPose {
    share: f64,
    gaussian: Gaussian<3>,
}

/// What [`GridLocalizer::update`] did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GridUpdate {
    /// Nothing but noting the odometry: the robot has not moved enough since the last update.
    StoodStill,
    /// The belief was moved along, but no beam of the scan says anything.
    Blind,
    /// The belief was moved along and corrected.
    Done(GridReport),
}

/// How an update went.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridReport {
    /// Logarithm of the mean likelihood of the scan over the predicted belief.
    pub log_evidence: f64,
    /// How many cells of the grid over the map were rated.
    pub rated: usize,
    /// Upper bound of the probability of all other cells together.
    pub passed_over: f64,
}

impl GridLocalizer {
    /// A robot that may be anywhere on the free part of a map.
    ///
    /// # Errors
    /// Settings out of range; [`crate::Error::NoFreeSpace`], and [`loc_core::Error::Length`] for
    /// cells so small that the grid would not fit into memory.
    pub fn new(map: &OccupancyGrid, settings: GridSettings) -> Result<Self> {
        settings.check()?;
        Window::size(&settings.fine)?;
        let space = PoseSpace::new(map, &settings)?;
        let sensor = Sensor::new(map, &space, &settings)?;
        let belief = Belief::anywhere(&space);
        let gaussian = Gaussian { mean: Vector3::zeros(), covariance: Matrix3::identity() };
        let best = BestPose { share: 0.0, gaussian };
        let (path, has_scan, has_changed) = (None, false, true);
        let mut localizer =
            GridLocalizer { settings, space, sensor, belief, path, has_scan, best, has_changed };
        localizer.update_best();
        Ok(localizer)
    }

    /// What it was made with.
    pub fn settings(&self) -> &GridSettings {
        &self.settings
    }

    /// The robot is near a pose, with the uncertainty of `start` over (x, y, theta) \[m, m, rad\].
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief that is none, [`crate::Error::NoRoom`] where it has no free
    /// place in reach.
    pub fn start_at(&mut self, start: &Gaussian<3>) -> Result<()> {
        self.belief.start_near(start, &self.space, &self.settings)?;
        self.restart();
        Ok(())
    }

    /// Starts anew with a uniform belief: the robot may be anywhere.
    pub fn start_anywhere(&mut self) {
        self.belief.forget();
        self.restart();
    }

    fn restart(&mut self) {
        self.update_best();
        self.has_scan = false;
        self.path = self.path.map(|path| DrivenPath::starting_at(path.end()));
    }

    /// Adds a pose of the odometry between two scans: the noise of a motion depends on the length of its
    /// path, which its ends alone do not determine.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a pose that is not finite, which is not noted.
    pub fn odometry(&mut self, pose: Pose2) -> Result<()> {
        finite("x of the odometry [m]", pose.x)?;
        finite("y of the odometry [m]", pose.y)?;
        finite("heading of the odometry [rad]", pose.theta)?;
        self.path.get_or_insert(DrivenPath::starting_at(pose)).extend(pose);
        Ok(())
    }

    /// Updates with the pose of the odometry and the scan of a laser at `mounting` on the robot
    /// (`base_from_laser`), taken there. The first scan after a start counts in any case, later
    /// ones when the robot has moved enough.
    ///
    /// # Errors
    /// A scan that cannot be one ([`LaserScan::check`]) and a pose that is not finite; the belief
    /// stays as it was then.
    pub fn update(
        &mut self,
        odometry: Pose2,
        scan: &LaserScan,
        mounting: Pose2,
    ) -> Result<GridUpdate> {
        scan.check()?;
        finite("mounting of a laser", mounting.to_vector().sum())?;
        self.odometry(odometry)?;
        let Some(path) = self.path else { return Ok(GridUpdate::StoodStill) };
        let step = path.step();
        if self.has_scan
            && f64::hypot(step.x, step.y) < self.settings.update_distance
            && step.theta.abs() < self.settings.update_turn
        {
            return Ok(GridUpdate::StoodStill);
        }
        let GridLocalizer { settings, space, sensor, belief, .. } = self;
        belief.predict(&path, space, settings)?;
        self.path = Some(DrivenPath::starting_at(path.end()));
        self.has_scan = true;
        let mut update = GridUpdate::Blind;
        if let Some(scan) = Scan::new(scan, mounting, &sensor.field, space, settings) {
            let correction = belief.correct(&scan, sensor, space, settings.negligible);
            belief.focus(&correction, &scan, sensor, space, settings)?;
            update = GridUpdate::Done(GridReport {
                log_evidence: correction.log_evidence,
                rated: correction.cells.len(),
                passed_over: correction.passed_over,
            });
        }
        self.update_best();
        Ok(update)
    }

    /// Finds the most likely place: that of the fine grid, where there is one.
    fn update_best(&mut self) {
        let Belief { window, stack, anywhere, .. } = &self.belief;
        let in_window = window.as_ref().and_then(Window::gaussian);
        let peak = Peak::of(stack, &self.space, &self.settings.fine);
        self.best = match (in_window, peak) {
            (Some(gaussian), _) => BestPose { share: self.belief.in_window(), gaussian },
            (None, Some(Peak { share, gaussian, .. })) if share > *anywhere => {
                BestPose { share, gaussian }
            }
            _ => BestPose { share: 0.0, gaussian: self.mean() },
        };
    }

    /// Mean and covariance over (x, y, theta) \[m, m, rad\] of the most likely place, now: of the
    /// fine grid, where there is one, else of the surroundings of the most likely cell, carried along
    /// by the way since the last update. Of a robot that may be anywhere, those of the whole belief.
    pub fn belief(&self) -> Gaussian<3> {
        let BestPose { gaussian, .. } = self.best;
        self.path.map_or(gaussian, |path| self.settings.robot.path.belief_after(&path, &gaussian))
    }

    /// The probability of the place that [`belief`](GridLocalizer::belief) describes; 0 for a
    /// robot that may be anywhere.
    pub fn certainty(&self) -> f64 {
        self.best.share
    }

    /// The probability of a robot that may be anywhere, evenly: what all cells have that are not
    /// kept one by one.
    pub fn anywhere(&self) -> f64 {
        self.belief.anywhere
    }

    /// Up to `max` likely poses, the most probable first: each with its probability and its mean and
    /// covariance over (x, y, theta) \[m, m, rad\].
    pub fn peaks(&self, max: usize) -> Vec<(f64, Gaussian<3>)> {
        let Belief { stack, window, .. } = &self.belief;
        let peaks = Peak::several(stack, &self.space, &self.settings.fine, max);
        let coarse = peaks.into_iter().map(|peak| (peak.share, peak.gaussian));
        let fine = window.as_ref().and_then(Window::gaussian);
        let fine = fine.map(|gaussian| (self.belief.in_window(), gaussian));
        let mut all: Vec<(f64, Gaussian<3>)> = fine.into_iter().chain(coarse).collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        all.truncate(max);
        all
    }

    /// Mean and covariance over (x, y, theta) \[m, m, rad\] of the whole belief at the last update.
    pub fn mean(&self) -> Gaussian<3> {
        let Belief { stack, window, anywhere, .. } = &self.belief;
        let space = &self.space;
        let coarse = || stack.cells().map(|(layer, place, p)| (space.pose(layer, place), p));
        let fine = || {
            let windows = window.iter().flat_map(|w| w.stack().cells().map(move |cell| (w, cell)));
            windows.map(|(window, (layer, place, p))| (window.pose(layer, place), p))
        };
        let headings = space.size().headings as f64;
        let everywhere = || {
            let places = (0..space.size().layer()).map(move |place| (place, space.share(place)));
            let places = places.filter(|(_, share)| *share > 0.0);
            places.map(move |(place, share)| {
                let pose = space.pose(0, place);
                ([pose.x, pose.y], anywhere * share * headings)
            })
        };
        let mut sums = Sums::default();
        coarse().chain(fine()).for_each(|(pose, p)| sums.add(pose, p));
        everywhere().for_each(|(place, p)| sums.add_any_heading(place, p));
        // The belief adds up to 1, so there is something.
        let Some(mut spread) = sums.spread() else { return self.best.gaussian };
        coarse().chain(fine()).for_each(|(pose, p)| spread.add(pose, p));
        everywhere().for_each(|(place, p)| spread.add_any_heading(place, p));
        spread.gaussian(space.squares().resolution(), space.heading_step())
    }

    /// The squares of the map that probabilities are kept for.
    pub fn squares(&self) -> &GridFrame {
        self.space.squares()
    }

    /// The probability of each square at the last update, whatever the heading, row by row from the
    /// bottom; their sum is 1.
    pub fn position_probabilities(&self) -> Vec<f64> {
        let Belief { stack, window, anywhere, .. } = &self.belief;
        let size = self.space.size();
        let everywhere = anywhere * size.headings as f64;
        let mut sums: Vec<f64> =
            (0..size.layer()).map(|place| everywhere * self.space.share(place)).collect();
        stack.cells().for_each(|(_, place, p)| sums[place] += p);
        for (window, (layer, place, p)) in
            window.iter().flat_map(|w| w.stack().cells().map(move |cell| (w, cell)))
        {
            if let Some((_, place)) = self.space.cell_of(window.pose(layer, place)) {
                sums[place] += p;
            }
        }
        sums
    }
}

/// Tracks with the poses of an odometry and corrects with scans; a scan is one outcome.
impl Localizer for GridLocalizer {
    fn predict(&mut self, _stamp: f64, control: &Control) -> Result<()> {
        let Control::Odometry(pose) = control else { return Ok(()) };
        self.odometry(*pose)
    }

    fn correct(&mut self, _stamp: f64, measurement: &Measurement) -> Result<Vec<Outcome>> {
        self.has_changed = false;
        let Measurement::Scan { scan, mounting } = measurement else { return Ok(Vec::new()) };
        let odometry = self.path.map_or(Pose2::IDENTITY, |path| path.end());
        let update = self.update(odometry, scan, *mounting)?;
        self.has_changed = update != GridUpdate::StoodStill;
        let is_used = matches!(update, GridUpdate::Done(_));
        Ok(is_used.then_some(Outcome::of(Decision::Accepted)).into_iter().collect())
    }

    /// The pose of maximum probability after the last input; lost with the probability of all other places.
    fn estimate(&self, _stamp: f64) -> Result<Estimate> {
        Ok(Estimate::from(self.belief()).with_lost(1.0 - self.certainty()))
    }

    fn hypotheses(&self) -> Vec<Hypothesis> {
        let peaks = self.peaks(HYPOTHESES).into_iter();
        peaks.map(|(share, belief)| Hypothesis { share, belief }).collect()
    }

    fn grid_belief(&self) -> Option<GridBelief> {
        let probabilities = || self.position_probabilities().into_iter().map(|p| p as f32);
        let cells = *self.squares();
        self.has_changed.then(|| GridBelief { cells, probabilities: probabilities().collect() })
    }
}

// What can be read from the belief.
