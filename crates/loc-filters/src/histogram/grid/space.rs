//! The cells of a belief: squares of the map, and sectors of heading.

use super::settings::GridSettings;
use super::stack::Size;
use crate::{Error, Result};
use loc_core::{Pose2, angle};
use loc_maps::OccupancyGrid;
use loc_maps::grid::{Cell, GridFrame, Occupancy};
use nalgebra::Point2;
use std::f64::consts::TAU;

/// Maximum number of cells of a grid; a belief takes 16 bytes for each.
pub(super) const MAX_POSES: usize = 1 << 26;

/// Squares of whole map cells over the free part of a map, and evenly spaced headings.
///
/// A square is there for all poses in it. It counts as free as far as its map cells are.
#[derive(Debug, Clone)]
pub(super) struct PoseSpace {
    map: GridFrame,
    /// Map cells along a square's side.
    side: usize,
    /// The map cell in the lower left corner of the first square.
    corner: [usize; 2],
    squares: GridFrame,
    headings: usize,
    /// For each square how many of its map cells are free.
    free: Vec<u32>,
    all_free: f64,
    /// For each map cell whether it is free.
    is_free: Vec<bool>,
}

impl PoseSpace {
    pub(super) fn new(map: &OccupancyGrid, settings: &GridSettings) -> Result<Self> {
        let frame = *map.frame();
        let is_free: Vec<bool> =
            map.values().iter().map(|&value| Occupancy::of(value) == Occupancy::Free).collect();
        let [low, high] = bounds(&frame, &is_free)
            .ok_or(Error::NoFreeSpace { width: map.width(), height: map.height() })?;
        let side = (settings.cell / frame.resolution()).round().clamp(1.0, 1e6) as usize;
        let across = |k: usize| (high[k] - low[k]).div_ceil(side);
        let headings = (TAU / settings.heading - 1e-6).ceil().max(1.0) as usize;
        let size = Size { headings, rows: across(1), columns: across(0) };
        check_count(&size)?;
        let at = frame.to_map(low[0] as f64, low[1] as f64);
        let origin = Pose2 { x: at.x, y: at.y, theta: frame.origin().theta };
        let step = side as f64 * frame.resolution();
        let squares = GridFrame::new(size.columns, size.rows, step, origin)?;
        let mut free = vec![0; size.layer()];
        for (place, _) in is_free.iter().enumerate().filter(|(_, free)| **free) {
            let [column, row] = [place % frame.width() - low[0], place / frame.width() - low[1]];
            free[row / side * size.columns + column / side] += 1;
        }
        let all_free = free.iter().map(|&count| f64::from(count)).sum();
        Ok(PoseSpace { map: frame, side, corner: low, squares, headings, free, all_free, is_free })
    }

    /// How many headings, rows and columns there are.
    pub(super) fn size(&self) -> Size {
        let (rows, columns) = (self.squares.height(), self.squares.width());
        Size { headings: self.headings, rows, columns }
    }

    /// The squares.
    pub(super) fn squares(&self) -> &GridFrame {
        &self.squares
    }

    /// Map cells along a square's side.
    pub(super) fn side(&self) -> usize {
        self.side
    }

    /// Column and row of the map cell in the lower left corner of a square.
    pub(super) fn corner_of(&self, place: usize) -> [usize; 2] {
        let (row, column) = (place / self.squares.width(), place % self.squares.width());
        [self.corner[0] + column * self.side, self.corner[1] + row * self.side]
    }

    /// Whether a map cell is free; those off the map are not.
    pub(super) fn is_free(&self, column: usize, row: usize) -> bool {
        let inside = column < self.map.width();
        inside && self.is_free.get(row * self.map.width() + column).copied().unwrap_or(false)
    }

    /// Whether a point of the map is free \[m\].
    pub(super) fn is_free_at(&self, point: &Point2<f64>) -> bool {
        self.map.cell_at(point).is_some_and(|cell| self.is_free(cell.column, cell.row))
    }

    /// Whether a robot can be anywhere in a square.
    pub(super) fn has_room(&self, place: usize) -> bool {
        self.free[place] > 0
    }

    /// The share of a square in all poses, for one heading: the probability of a robot that may be
    /// anywhere.
    pub(super) fn share(&self, place: usize) -> f64 {
        f64::from(self.free[place]) / (self.all_free * self.headings as f64)
    }

    /// How many squares there is room in, over all headings.
    pub(super) fn room(&self) -> usize {
        self.free.iter().filter(|count| **count > 0).count() * self.headings
    }

    /// From one heading to the next \[rad\].
    pub(super) fn heading_step(&self) -> f64 {
        TAU / self.headings as f64
    }

    /// The heading of a layer in the frame of the grid \[rad\].
    pub(super) fn heading_in_grid(&self, layer: usize) -> f64 {
        layer as f64 * self.heading_step()
    }

    /// The heading of a layer in the map \[rad\].
    pub(super) fn heading(&self, layer: usize) -> f64 {
        angle::wrap(self.map.origin().theta + layer as f64 * self.heading_step())
    }

    /// The layer to which a heading of the map belongs \[rad\].
    pub(super) fn layer(&self, heading: f64) -> usize {
        let turned = (heading - self.map.origin().theta) / self.heading_step();
        turned.round().rem_euclid(self.headings as f64) as usize % self.headings
    }

    /// The pose in the middle of a cell.
    pub(super) fn pose(&self, layer: usize, place: usize) -> Pose2 {
        let cell = Cell::new(place % self.squares.width(), place / self.squares.width());
        let at = self.squares.center(cell);
        Pose2 { x: at.x, y: at.y, theta: self.heading(layer) }
    }

    /// Layer and place of a pose; `None` outside of the squares.
    pub(super) fn cell_of(&self, pose: Pose2) -> Option<(usize, usize)> {
        let cell = self.squares.cell_at(&pose.position())?;
        Some((self.layer(pose.theta), self.squares.index(cell)?))
    }
}

/// The box around all free cells: its lowest column and row, and those after its highest.
fn bounds(frame: &GridFrame, is_free: &[bool]) -> Option<[[usize; 2]; 2]> {
    let mut found: Option<[[usize; 2]; 2]> = None;
    for (place, _) in is_free.iter().enumerate().filter(|(_, free)| **free) {
        let at = [place % frame.width(), place / frame.width()];
        let [low, high] = found.unwrap_or([at, at]);
        let low = [low[0].min(at[0]), low[1].min(at[1])];
        found = Some([low, [high[0].max(at[0] + 1), high[1].max(at[1] + 1)]]);
    }
    found
}

/// Refuses grids that do not fit into memory.
pub(super) fn check_count(size: &Size) -> Result<()> {
    let count = size.headings.saturating_mul(size.rows).saturating_mul(size.columns);
    if count > MAX_POSES {
        let expected = "at most 2^26 poses (squares x headings): larger cells, or fewer headings";
        let (what, found) = ("grid of poses", count);
        return Err(loc_core::Error::Length { what, expected, found }.into());
    }
    Ok(())
}
