//! The belief at two resolutions, with its prediction and correction.
//!
//! Three parts that add up to 1: a grid over the whole map, a fine grid about the most likely
//! place, and the share of a robot that may be anywhere, evenly. The last one stands for all cells
//! that are too unlikely to be kept one by one, and for a kidnapped robot.

use super::correct::{Correction, Prior, Scan, Sensor};
use super::settings::{FineSettings, GridSettings};
use super::space::PoseSpace;
use super::stack::{Stack, Sums};
use super::window::{Lattice, Place, Step, Window};
use crate::{Error, Result};
use loc_core::motion::DrivenPath;
use loc_core::{Gaussian, Pose2, angle};
use nalgebra::{Matrix3, Vector3};
use std::collections::BTreeMap;

/// The fine grid is opened at the most likely place once that has this probability.
const FINE_FROM_SHARE: f64 = 0.2;

/// A total probability below this counts as 0.
const MIN_TOTAL: f64 = 1e-12;

#[derive(Debug, Clone)]
pub(super) struct Belief {
    pub(super) stack: Stack,
    pub(super) anywhere: f64,
    pub(super) window: Option<Window>,
    /// Where the next stack is put together.
    scratch: Stack,
}

impl Belief {
    /// A robot that may be anywhere.
    pub(super) fn anywhere(space: &PoseSpace) -> Self {
        let stack = Stack::new(space.size());
        Belief { scratch: stack.clone(), stack, anywhere: 1.0, window: None }
    }

    /// The robot may be anywhere again.
    pub(super) fn forget(&mut self) {
        self.stack.clear();
        (self.anywhere, self.window) = (1.0, None);
    }

    /// The share of the fine grid.
    pub(super) fn in_window(&self) -> f64 {
        self.window.as_ref().map_or(0.0, |window| window.stack().total())
    }

    /// Prediction over a step. Of the whole belief, the share of faults moves as by an odometry
    /// that has failed, in the coarse grid. What would be in walls afterwards is ruled out. At the
    /// end the robot is anywhere with the probability of a kidnapping.
    pub(super) fn predict(
        &mut self,
        path: &DrivenPath,
        space: &PoseSpace,
        settings: &GridSettings,
    ) -> Result<()> {
        let squares = space.squares();
        let lattice = Lattice { cell: squares.resolution(), heading_step: space.heading_step() };
        let diagonal = f64::hypot(squares.width() as f64, squares.height() as f64) * lattice.cell;
        if path.length() > diagonal {
            // Beyond the map, whatever odometry says.
            self.forget();
            return Ok(());
        }
        let usual = Step::usual(path, &settings.robot.path);
        let faulty = Step::faulty(path, &settings.robot.path);
        faulty.check(&lattice)?;
        if self.window.as_ref().is_some_and(|window| !window.can_follow(&usual)) {
            self.close_window(space);
        }
        let faults = settings.robot.path.fault_probability;
        self.scratch.clear();
        self.move_coarse(&usual, 1.0 - faults, space, &lattice)?;
        self.move_coarse(&faulty, faults, space, &lattice)?;
        self.move_window(&usual, &faulty, faults, space, &lattice)?;
        std::mem::swap(&mut self.stack, &mut self.scratch);
        self.clear_walls(space);
        self.scale_to(1.0);
        self.scale_to_rest(settings.kidnap_rate);
        Ok(())
    }

    fn move_coarse(
        &mut self,
        step: &Step,
        share: f64,
        space: &PoseSpace,
        lattice: &Lattice,
    ) -> Result<()> {
        if share <= 0.0 {
            return Ok(());
        }
        let moves = |layer| Ok(step.layer_move(lattice, space.heading_in_grid(layer), [0.0, 0.0]));
        self.scratch.add_moved(&self.stack, share, moves, &step.turn(lattice, 0.0), true)
    }

    /// The fine grid follows the usual step; faults go to the coarse grid, and what leaves the fine
    /// one may be anywhere.
    fn move_window(
        &mut self,
        usual: &Step,
        faulty: &Step,
        faults: f64,
        space: &PoseSpace,
        lattice: &Lattice,
    ) -> Result<()> {
        let Some(window) = self.window.as_mut() else { return Ok(()) };
        if faults > 0.0 {
            let mut coarse = Stack::new(space.size());
            self.anywhere += faults * deposit(window, &mut coarse, space);
            let moves =
                |layer| Ok(faulty.layer_move(lattice, space.heading_in_grid(layer), [0.0, 0.0]));
            self.scratch.add_moved(&coarse, faults, moves, &faulty.turn(lattice, 0.0), true)?;
        }
        let before = (1.0 - faults) * window.stack().total();
        window.follow(usual, 1.0 - faults)?;
        self.anywhere += (before - window.stack().total()).max(0.0);
        Ok(())
    }

    fn clear_walls(&mut self, space: &PoseSpace) {
        self.stack.change(|_, place, mass| if space.has_room(place) { mass } else { 0.0 });
        if let Some(window) = self.window.as_mut() {
            window.clear_walls(space);
        }
    }

    /// Puts the fine grid back into the coarse one.
    pub(super) fn close_window(&mut self, space: &PoseSpace) {
        if let Some(window) = self.window.take() {
            self.anywhere += deposit(&window, &mut self.stack, space);
        }
    }

    /// Scales all parts so that they add up to `total`; a belief of nothing becomes that of a robot
    /// that may be anywhere.
    fn scale_to(&mut self, total: f64) {
        let sum = self.stack.total() + self.in_window() + self.anywhere;
        if !(sum > MIN_TOTAL && sum.is_finite()) {
            self.forget();
            return;
        }
        self.scale_by(total / sum);
        self.anywhere *= total / sum;
    }

    /// Scales both grids, and gives what they lose to a robot that may be anywhere.
    fn scale_to_rest(&mut self, share: f64) {
        self.scale_by(1.0 - share);
        self.anywhere = self.anywhere * (1.0 - share) + share;
    }

    fn scale_by(&mut self, factor: f64) {
        self.stack.change(|_, _, mass| factor * mass);
        if let Some(window) = self.window.as_mut() {
            window.stack_mut().change(|_, _, mass| factor * mass);
        }
    }

    /// Correction with a scan; returns what it has computed.
    // ANCHOR: correct
    pub(super) fn correct(
        &mut self,
        scan: &Scan,
        sensor: &Sensor,
        space: &PoseSpace,
        negligible: f64,
    ) -> Correction {
        let Belief { stack, anywhere, window, .. } = self;
        let prior = Prior { stack, anywhere: *anywhere, window: window.as_ref() };
        let correction = Correction::new(sensor, space, scan, prior, negligible);
        let log_evidence = correction.log_evidence;
        let least = negligible / space.room() as f64;
        self.stack.clear();
        self.anywhere = correction.passed_over;
        for &((layer, place), log_weight) in &correction.cells {
            let mass = (log_weight - log_evidence).exp();
            if mass > least {
                self.stack.add(layer, place, mass);
            } else {
                self.anywhere += mass;
            }
        }
        if let Some(window) = self.window.as_mut() {
            let layer_length = window.stack().size().layer();
            window.stack_mut().change(|layer, place, mass| {
                let log_likelihood = correction.fine[layer * layer_length + place];
                mass * (log_likelihood - log_evidence).exp()
            });
        }
        self.scale_to(1.0);
        correction
    }
    // ANCHOR_END: correct

    /// A robot near a pose; one that is known well goes into the fine grid.
    pub(super) fn start_near(
        &mut self,
        start: &Gaussian<3>,
        space: &PoseSpace,
        settings: &GridSettings,
    ) -> Result<()> {
        let [x, y, theta] = [0, 1, 2].map(|k| 3.0 * start.covariance[(k, k)].sqrt());
        let mut stack = Stack::new(space.size());
        let mut window = None;
        if x.max(y) <= settings.fine.reach && theta <= settings.fine.turn {
            let mut fine = Window::at(start.pose(), &settings.fine)?;
            let density = Density::new(start, settings.fine.cell, settings.fine.heading)?;
            let rate = |layer, place| {
                let pose = fine.pose(layer, place);
                space.is_free_at(&pose.position()).then(|| density.log(pose))
            };
            let mut filled = Stack::new(fine.stack().size());
            fill(&mut filled, rate)?;
            *fine.stack_mut() = filled;
            window = Some(fine);
        } else {
            let (cell, sector) = (space.squares().resolution(), space.heading_step());
            let density = Density::new(start, cell, sector)?;
            let rate =
                |layer, place| space.has_room(place).then(|| density.log(space.pose(layer, place)));
            fill(&mut stack, rate)?;
        }
        (self.stack, self.window, self.anywhere) = (stack, window, 0.0);
        Ok(())
    }

    /// Moves what the coarse grid has within the reach of the fine one into that, after a correction
    /// with `scan`; moves it to another place where that is more likely.
    pub(super) fn focus(
        &mut self,
        correction: &Correction,
        scan: &Scan,
        sensor: &Sensor,
        space: &PoseSpace,
        settings: &GridSettings,
    ) -> Result<()> {
        let mut fine: Option<Vec<f64>> = None;
        let peak = Peak::of(&self.stack, space, &settings.fine);
        let followed = self.in_window();
        if let Some(peak) = peak.filter(|p| p.share >= FINE_FROM_SHARE && p.share > followed) {
            self.close_window(space);
            let window = Window::at(peak.gaussian.pose(), &settings.fine)?;
            fine = Some(sensor.rate_window(&window, scan));
            self.window = Some(window);
        }
        let likelihoods = fine.as_ref().unwrap_or(&correction.fine);
        self.absorb(likelihoods, space);
        self.recenter()
    }

    /// Moves what the coarse grid has within the reach of the fine one into that.
    fn absorb(&mut self, log_likelihoods: &[f64], space: &PoseSpace) {
        let Some(window) = self.window.as_mut() else { return };
        let within: BTreeMap<Place, f64> = self
            .stack
            .cells()
            .filter(|(layer, place, _)| window.cell_of(space.pose(*layer, *place)).is_some())
            .map(|(layer, place, mass)| ((layer, place), mass))
            .collect();
        if within.is_empty() {
            return;
        }
        let highest = log_likelihoods.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let layer_length = window.stack().size().layer();
        let left = window.absorb(&within, space, |layer, place| {
            (log_likelihoods[layer * layer_length + place] - highest).exp()
        });
        self.stack.change(|layer, place, mass| {
            let taken = within.contains_key(&(layer, place)) && !left.contains(&(layer, place));
            if taken { 0.0 } else { mass }
        });
    }

    fn recenter(&mut self) -> Result<()> {
        let Some(window) = self.window.as_mut() else { return Ok(()) };
        let before = window.stack().total();
        if let Some(gaussian) = window.gaussian() {
            window.recenter(gaussian.pose())?;
        }
        self.anywhere += (before - window.stack().total()).max(0.0);
        Ok(())
    }
}

/// Adds a fine grid to a coarse one; returns what lies outside of that.
fn deposit(window: &Window, coarse: &mut Stack, space: &PoseSpace) -> f64 {
    let mut outside = 0.0;
    for (layer, place, mass) in window.stack().cells() {
        match space.cell_of(window.pose(layer, place)) {
            Some((layer, place)) => coarse.add(layer, place, mass),
            None => outside += mass,
        }
    }
    outside
}

/// A normal distribution, with the extent of the cells that it is put into.
struct Density {
    start: Gaussian<3>,
    information: Matrix3<f64>,
}

impl Density {
    fn new(start: &Gaussian<3>, cell: f64, sector: f64) -> Result<Self> {
        let start = Gaussian::new(start.mean, start.covariance)?;
        let extent = Vector3::new(cell * cell, cell * cell, sector * sector) / 12.0;
        let covariance = start.covariance + Matrix3::from_diagonal(&extent);
        let inverse = covariance.cholesky().map(|factor| factor.inverse());
        let information = inverse.ok_or_else(|| loc_core::Error::NotACovariance {
            what: "covariance of the start",
            expected: "positive semi-definite",
            found: start.covariance.to_string(),
        })?;
        Ok(Density { start, information })
    }

    /// Logarithm of the density, but for a constant.
    fn log(&self, pose: Pose2) -> f64 {
        let off = self.start.pose_deviation(pose);
        -0.5 * off.dot(&(self.information * off))
    }
}

/// Below this \[nat\] a cell has no part in a start: nearly eight standard deviations away.
const FAINT: f64 = -30.0;

/// Gives the cells that have a density a total of 1.
fn fill(stack: &mut Stack, log_density: impl Fn(usize, usize) -> Option<f64>) -> Result<()> {
    let size = stack.size();
    let cells = || (0..size.headings).flat_map(|layer| (0..size.layer()).map(move |k| (layer, k)));
    let rated =
        cells().filter_map(|(layer, place)| Some((layer, place, log_density(layer, place)?)));
    let rated: Vec<(usize, usize, f64)> = rated.collect();
    let highest = rated.iter().map(|cell| cell.2).fold(f64::NEG_INFINITY, f64::max);
    if highest.is_nan() || highest <= FAINT {
        return Err(Error::NoRoom { what: "start of the robot" });
    }
    let worthy = || rated.iter().filter(|cell| cell.2 - highest > FAINT);
    let total: f64 = worthy().map(|cell| (cell.2 - highest).exp()).sum();
    worthy()
        .for_each(|&(layer, place, log)| stack.add(layer, place, (log - highest).exp() / total));
    Ok(())
}

/// The places about the most likely cell of the coarse grid, as far as a fine grid reaches.
#[derive(Debug, Clone, Copy)]
pub(super) struct Peak {
    /// Their probability.
    pub(super) share: f64,
    /// Their mean and covariance.
    pub(super) gaussian: Gaussian<3>,
    /// The pose of the most likely cell.
    middle: Pose2,
}

impl Peak {
    /// The place about the most likely cell of those that `is_open` lets count; `None` where these
    /// hold nothing.
    fn among(
        stack: &Stack,
        space: &PoseSpace,
        settings: &FineSettings,
        is_open: impl Fn(Pose2) -> bool,
    ) -> Option<Self> {
        let open = || {
            let cells = stack.cells().map(|(layer, place, mass)| (space.pose(layer, place), mass));
            cells.filter(|(pose, _)| is_open(*pose))
        };
        let (middle, _) = open().reduce(|best, cell| if cell.1 > best.1 { cell } else { best })?;
        let near = || open().filter(|(pose, _)| is_within(*pose, middle, settings));
        let (cell, sector) = (space.squares().resolution(), space.heading_step());
        let (share, gaussian) = Sums::gaussian(near, cell, sector)?;
        Some(Peak { share, gaussian, middle })
    }

    /// `None` for a grid that holds nothing.
    pub(super) fn of(stack: &Stack, space: &PoseSpace, settings: &FineSettings) -> Option<Self> {
        Peak::among(stack, space, settings, |_| true)
    }

    /// Up to `most` places that do not overlap, the most likely cells first.
    pub(super) fn several(
        stack: &Stack,
        space: &PoseSpace,
        settings: &FineSettings,
        most: usize,
    ) -> Vec<Self> {
        let mut peaks: Vec<Peak> = Vec::new();
        while peaks.len() < most {
            let is_open =
                |pose: Pose2| peaks.iter().all(|peak| !is_within(pose, peak.middle, settings));
            let Some(peak) = Peak::among(stack, space, settings, is_open) else { break };
            peaks.push(peak);
        }
        peaks
    }
}

fn is_within(pose: Pose2, middle: Pose2, settings: &FineSettings) -> bool {
    (pose.x - middle.x).abs() <= settings.reach
        && (pose.y - middle.y).abs() <= settings.reach
        && angle::difference(pose.theta, middle.theta).abs() <= settings.turn
}
