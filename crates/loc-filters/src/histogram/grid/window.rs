//! The fine grid that follows the most likely place.
//!
//! It reaches some decimetres and degrees to all sides, and moves along with the odometry, so that
//! its cells need not: only what odometry may be off by blurs them. What leaves it is
//! handed back.

use super::settings::FineSettings;
use super::space::{PoseSpace, check_count};
use super::stack::{LayerMove, Size, Stack, Sums};
use crate::Result;
use crate::histogram::Kernel;
use loc_core::motion::{DrivenPath, PathNoise};
use loc_core::{Gaussian, Pose2, angle};
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Layer and place of a cell of the coarse grid.
pub(super) type Place = (usize, usize);

#[derive(Debug, Clone)]
pub(super) struct Window {
    /// The pose in the middle.
    center: Pose2,
    lattice: Lattice,
    /// Cells from the middle to the edge along the axes of the map, and headings to either side.
    reach: [usize; 2],
    stack: Stack,
}

impl Window {
    /// How many cells it will have.
    ///
    /// # Errors
    /// [`loc_core::Error::Length`] for more than fit into memory.
    pub(super) fn size(settings: &FineSettings) -> Result<Size> {
        let [across, headings] = reach(settings).map(|reach| 2 * reach + 1);
        let size = Size { headings, rows: across, columns: across };
        check_count(&size)?;
        Ok(size)
    }

    /// An empty one.
    pub(super) fn at(center: Pose2, settings: &FineSettings) -> Result<Self> {
        let size = Window::size(settings)?;
        let lattice = Lattice { cell: settings.cell, heading_step: settings.heading };
        Ok(Window { center, lattice, reach: reach(settings), stack: Stack::new(size) })
    }

    pub(super) fn stack(&self) -> &Stack {
        &self.stack
    }

    pub(super) fn stack_mut(&mut self) -> &mut Stack {
        &mut self.stack
    }

    /// The pose in the middle of a cell.
    pub(super) fn pose(&self, layer: usize, place: usize) -> Pose2 {
        let width = self.stack.size().columns;
        let off = |index: usize, middle: usize, step: f64| (index as f64 - middle as f64) * step;
        Pose2 {
            x: self.center.x + off(place % width, self.reach[0], self.lattice.cell),
            y: self.center.y + off(place / width, self.reach[0], self.lattice.cell),
            theta: angle::wrap(self.heading(layer)),
        }
    }

    fn heading(&self, layer: usize) -> f64 {
        self.center.theta + (layer as f64 - self.reach[1] as f64) * self.lattice.heading_step
    }

    /// The cell that a pose lies in.
    pub(super) fn cell_of(&self, pose: Pose2) -> Option<Place> {
        let index = |off: f64, step: f64, reach: usize| {
            let index = (off / step).round() + reach as f64;
            (index >= 0.0 && index <= (2 * reach) as f64).then_some(index as usize)
        };
        let column = index(pose.x - self.center.x, self.lattice.cell, self.reach[0])?;
        let row = index(pose.y - self.center.y, self.lattice.cell, self.reach[0])?;
        let turned = angle::difference(pose.theta, self.center.theta);
        let layer = index(turned, self.lattice.heading_step, self.reach[1])?;
        Some((layer, row * self.stack.size().columns + column))
    }

    /// Whether a step keeps nearly all that is here within reach.
    pub(super) fn can_follow(&self, step: &Step) -> bool {
        let [position, heading] = step.deviations();
        3.0 * position <= self.lattice.cell * self.reach[0] as f64
            && 3.0 * heading <= self.lattice.heading_step * self.reach[1] as f64
    }

    /// Moves along with a step and blurs by its noise; keeps the share `share`.
    pub(super) fn follow(&mut self, step: &Step, share: f64) -> Result<()> {
        let (sin, cos) = self.center.theta.sin_cos();
        let drift = [cos * step.by.x - sin * step.by.y, sin * step.by.x + cos * step.by.y];
        let moves = |layer| Ok(step.layer_move(&self.lattice, self.heading(layer), drift));
        let mut after = Stack::new(self.stack.size());
        after.add_moved(
            &self.stack,
            share,
            moves,
            &step.turn(&self.lattice, step.by.theta),
            false,
        )?;
        self.stack = after;
        self.center = self.center * step.by;
        Ok(())
    }

    /// Empties the cells that are not free.
    pub(super) fn clear_walls(&mut self, space: &PoseSpace) {
        let size = self.stack.size();
        let free: Vec<bool> = (0..size.layer())
            .map(|place| space.is_free_at(&self.pose(0, place).position()))
            .collect();
        self.stack.change(|_, place, mass| if free[place] { mass } else { 0.0 });
    }

    /// Mean and covariance of what is here; `None` without anything.
    pub(super) fn gaussian(&self) -> Option<Gaussian<3>> {
        let cells = || {
            let cells = self.stack.cells();
            cells.map(|(layer, place, mass)| (self.pose(layer, place), mass))
        };
        let (_, gaussian) = Sums::gaussian(cells, self.lattice.cell, self.lattice.heading_step)?;
        Some(gaussian)
    }

    /// Moves the middle by whole cells to where the mean of what is here lies.
    pub(super) fn recenter(&mut self, mean: Pose2) -> Result<()> {
        let whole = |off: f64, step: f64| (off / step).round();
        let columns = whole(mean.x - self.center.x, self.lattice.cell);
        let rows = whole(mean.y - self.center.y, self.lattice.cell);
        let turned = angle::difference(mean.theta, self.center.theta);
        let layers = whole(turned, self.lattice.heading_step);
        if columns.abs() + rows.abs() + layers.abs() < 0.5 {
            return Ok(());
        }
        let by = LayerMove { across: Kernel::new(-columns, 0.0)?, up: Kernel::new(-rows, 0.0)? };
        let mut after = Stack::new(self.stack.size());
        after.add_moved(
            &self.stack,
            1.0,
            |_| Ok(by.clone()),
            &Kernel::new(-layers, 0.0)?,
            false,
        )?;
        self.stack = after;
        self.center = Pose2::new(
            self.center.x + columns * self.lattice.cell,
            self.center.y + rows * self.lattice.cell,
            self.center.theta + layers * self.lattice.heading_step,
        );
        Ok(())
    }

    /// Moves the probabilities of cells here of the coarse grid, and shares each out among the fine
    /// cells in it, in proportion to `weight` of their layer and place. Returns the coarse cells
    /// that have none here.
    pub(super) fn absorb(
        &mut self,
        coarse: &BTreeMap<Place, f64>,
        space: &PoseSpace,
        weight: impl Fn(usize, usize) -> f64,
    ) -> Vec<Place> {
        let size = self.stack.size();
        let mut shares: BTreeMap<Place, f64> = coarse.keys().map(|place| (*place, 0.0)).collect();
        let mut parts: Vec<(Place, Place, f64)> = Vec::new();
        for place in 0..size.layer() {
            let Some((_, square)) = space.cell_of(self.pose(0, place)) else { continue };
            if !space.is_free_at(&self.pose(0, place).position()) {
                continue;
            }
            for layer in 0..size.headings {
                let owner = (space.layer(self.heading(layer)), square);
                if let Some(share) = shares.get_mut(&owner) {
                    let weight = weight(layer, place);
                    *share += weight;
                    parts.push((owner, (layer, place), weight));
                }
            }
        }
        for (owner, (layer, place), weight) in parts {
            let (share, mass) = (shares[&owner], coarse[&owner]);
            if share > 0.0 && weight > 0.0 {
                self.stack.add(layer, place, mass * weight / share);
            }
        }
        shares.into_iter().filter(|(_, share)| *share <= 0.0).map(|(place, _)| place).collect()
    }
}

/// Cells and headings to either side.
fn reach(settings: &FineSettings) -> [usize; 2] {
    [settings.reach / settings.cell, settings.turn / settings.heading]
        .map(|cells| cells.round().clamp(1.0, 1e6) as usize)
}

/// Errors of a usual step beyond so many standard deviations are left out ..
const USUAL_TAIL: f64 = 4.0;

/// .. and of a step in which odometry has failed, which is a rough guess anyway.
const FAULTY_TAIL: f64 = 3.0;

/// A step with its noise, ready to move layers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    pub(super) by: Pose2,
    /// Variances along, across \[m^2\] and of the heading \[rad^2\].
    variances: Vector3<f64>,
    tail: f64,
}

/// The cells that a step moves probabilities between.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lattice {
    /// Side of a cell \[m\].
    pub(super) cell: f64,
    /// From one layer to the next \[rad\].
    pub(super) heading_step: f64,
}

impl Step {
    /// The step as odometry usually reports it.
    pub(super) fn usual(path: &DrivenPath, noise: &PathNoise) -> Self {
        let least = [noise.min_position, noise.min_position, noise.min_heading];
        let variances = noise.variances(path) + Vector3::from(least.map(|sigma| sigma * sigma));
        Step { by: path.step(), variances, tail: USUAL_TAIL }
    }

    /// The step of an odometry that has failed.
    pub(super) fn faulty(path: &DrivenPath, noise: &PathNoise) -> Self {
        let usual = Step::usual(path, noise);
        let fault = PathNoise::fault_sigmas(path);
        let variances = usual.variances + fault.component_mul(&fault);
        Step { variances, tail: FAULTY_TAIL, ..usual }
    }

    /// How a layer moves in which the robot has the heading `heading` \[rad\] of the lattice, while the
    /// lattice itself moves by `drift` \[m\].
    ///
    /// The heading is anything within its layer, and its mean error over the motion is half of
    /// that at the end: both blur across the motion. Kernels work along columns and rows,
    /// so the correlation of the errors of x and y is left out.
    pub(super) fn layer_move(&self, lattice: &Lattice, heading: f64, drift: [f64; 2]) -> LayerMove {
        let (sin, cos) = heading.sin_cos();
        let (dx, dy) = (cos * self.by.x - sin * self.by.y, sin * self.by.x + cos * self.by.y);
        let [along, across, turn] = [0, 1, 2].map(|k| self.variances[k]);
        let of_heading = lattice.heading_step.powi(2) / 12.0 + 0.25 * turn;
        let x = cos * cos * along + sin * sin * across + dy * dy * of_heading;
        let y = sin * sin * along + cos * cos * across + dx * dx * of_heading;
        let kernel = |shift: f64, variance: f64| {
            Kernel::cut_off(shift / lattice.cell, variance.sqrt() / lattice.cell, self.tail)
        };
        LayerMove { across: kernel(dx - drift[0], x), up: kernel(dy - drift[1], y) }
    }

    /// How probability moves between layers, which themselves turn by `drift` \[rad\].
    pub(super) fn turn(&self, lattice: &Lattice, drift: f64) -> Kernel {
        let step = lattice.heading_step;
        Kernel::cut_off((self.by.theta - drift) / step, self.variances[2].sqrt() / step, self.tail)
    }

    /// Largest standard deviations of the position \[m\] and the heading \[rad\].
    pub(super) fn deviations(&self) -> [f64; 2] {
        let way = self.by.x.powi(2) + self.by.y.powi(2);
        let position = self.variances[0].max(self.variances[1]) + 0.25 * way * self.variances[2];
        [position.sqrt(), self.variances[2].sqrt()]
    }

    /// Whether kernels of this step stay small enough to be computed.
    pub(super) fn check(&self, lattice: &Lattice) -> Result<()> {
        let [position, _] = self.deviations();
        let largest = (position + self.by.x.abs() + self.by.y.abs()) / lattice.cell;
        Kernel::check(largest, largest)
    }
}
