//! The fine grid that follows the most likely place.
//!
//! It reaches some decimetres and degrees to all sides, and moves along with the odometry, so that
//! its cells need not: only what odometry may be off by blurs them. What leaves it is not lost but
//! handed back.

use super::moments::Sums;
use super::motion::{Lattice, Step};
use super::settings::FineSettings;
use super::space::{PoseSpace, check_count};
use super::stack::{LayerMove, Size, Stack};
use crate::Result;
use crate::histogram::Kernel;
use loc_core::{Gaussian, Pose2, angle};
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

    /// Takes over the probabilities of cells of the coarse grid, and shares each out among the fine
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
