//! What is believed, at two resolutions, and how it follows motions and scans.
//!
//! Three parts that add up to 1: a grid over the whole map, a fine grid about the most likely
//! place, and the share of a robot that may be anywhere, evenly. The last one stands for all cells
//! that are too unlikely to be kept one by one, and for a robot that was carried off.

use super::correct::{Correction, Prior};
use super::motion::{Lattice, Step};
use super::scan::Scan;
use super::sensor::Sensor;
use super::settings::GridSettings;
use super::space::PoseSpace;
use super::stack::Stack;
use super::window::Window;
use crate::Result;
use loc_core::motion::DrivenPath;

/// Less than this is nothing: a belief that cannot be.
const NOTHING: f64 = 1e-12;

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

    /// Takes along a step. Of all that is believed, the share of faults moves as by an odometry
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
        let usual = Step::usual(path, &settings.motion);
        let faulty = Step::faulty(path, &settings.motion);
        faulty.check(&lattice)?;
        if self.window.as_ref().is_some_and(|window| !window.can_follow(&usual)) {
            self.close_window(space);
        }
        let faults = settings.motion.fault_probability;
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
        if !(sum > NOTHING && sum.is_finite()) {
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

    /// Takes in a scan; what the correction found is handed back.
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
