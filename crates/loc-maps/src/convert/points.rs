//! Grids and lines turned into points.

use crate::grid::{Cell, Occupancy, OccupancyGrid};
use crate::{LineMap, PointMap, Result};
use loc_core::error::positive;
use nalgebra::Point2;

/// The most points that sampled lines may give.
const MAX_POINTS: f64 = 1e8;

/// Which occupied cells of a grid become points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Surface {
    /// All of them.
    All,
    /// Those with a free cell among their eight neighbours: what a sensor can hit.
    Boundary,
}

impl PointMap {
    /// The centres of the occupied cells of a grid, row by row from the bottom.
    ///
    /// Beams of the map are half as wide as a cell is long across, so that none slips between two
    /// neighbouring cells.
    ///
    /// # Errors
    /// As [`PointMap::new`], for grids more than 1000 km from the origin.
    pub fn from_grid(grid: &OccupancyGrid, surface: Surface) -> Result<Self> {
        let cells = surface_cells(grid, surface);
        let half_width = grid.resolution() * std::f64::consts::FRAC_1_SQRT_2;
        PointMap::new(cells.map(|cell| grid.frame().center(cell)))?.with_half_width(half_width)
    }

    /// Points along lines, both ends included, at most `spacing` \[m\] apart.
    ///
    /// # Errors
    /// [`loc_core::Error`] for a spacing that is not positive, or so small that it gives over 1e8
    /// points.
    pub fn from_lines(lines: &LineMap, spacing: f64) -> Result<Self> {
        positive("spacing of points on lines [m]", spacing)?;
        let steps = |length: f64| (length / spacing).ceil().max(1.0);
        let total: f64 = lines.lines().iter().map(|line| steps(line.length()) + 1.0).sum();
        if total > MAX_POINTS {
            let (what, expected) = ("points along lines", "at most 1e8");
            return Err(loc_core::Error::OutOfRange { what, expected, found: total }.into());
        }
        let sampled = |line: &crate::LineSegment| -> Vec<Point2<f64>> {
            let (line, steps) = (*line, steps(line.length()));
            // At most 1e8, so that the cast is exact.
            (0..=steps as usize).map(|k| line.at(k as f64 / steps)).collect()
        };
        PointMap::new(lines.lines().iter().flat_map(sampled))
    }
}

/// The occupied cells of a grid, or only those next to a free one.
pub(super) fn surface_cells(
    grid: &OccupancyGrid,
    surface: Surface,
) -> impl Iterator<Item = Cell> + '_ {
    let occupied = grid.iter().filter(|&(_, value)| Occupancy::of(value) == Occupancy::Occupied);
    let wanted = move |cell: &Cell| surface == Surface::All || beside_free(grid, *cell);
    occupied.map(|(cell, _)| cell).filter(wanted)
}

fn beside_free(grid: &OccupancyGrid, cell: Cell) -> bool {
    let around = |middle: usize| middle.saturating_sub(1)..=middle + 1;
    around(cell.row).any(|row| {
        around(cell.column).any(|column| grid.occupancy(Cell::new(column, row)) == Occupancy::Free)
    })
}
