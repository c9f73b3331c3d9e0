//! The outline of a grid's walls, exact to the cell.

use crate::grid::{Cell, Occupancy, OccupancyGrid};
use crate::{LineMap, LineSegment, Result};

impl LineMap {
    /// The borders between occupied and free cells as lines, longest first.
    ///
    /// This is the drawing of a world that is made of cells: a ray through the grid ends on it.
    /// Where cells only sample walls, as in a map that a robot has built,
    /// [`from_grid`](LineMap::from_grid) is nearer to them.
    ///
    /// # Errors
    /// As [`LineMap::new`], for grids more than 1000 km from the origin.
    pub fn outline(grid: &OccupancyGrid) -> Result<Self> {
        let frame = *grid.frame();
        let (width, height) = (frame.width(), frame.height());
        let mut lines = Vec::new();
        for v in 1..height {
            let sides = |u: usize| (Cell::new(u, v - 1), Cell::new(u, v));
            let line = |from: usize, to: usize| LineSegment {
                start: frame.to_map(from as f64, v as f64),
                end: frame.to_map(to as f64, v as f64),
            };
            lines.extend(runs(grid, width, sides).into_iter().map(|[from, to]| line(from, to)));
        }
        for u in 1..width {
            let sides = |v: usize| (Cell::new(u - 1, v), Cell::new(u, v));
            let line = |from: usize, to: usize| LineSegment {
                start: frame.to_map(u as f64, from as f64),
                end: frame.to_map(u as f64, to as f64),
            };
            lines.extend(runs(grid, height, sides).into_iter().map(|[from, to]| line(from, to)));
        }
        lines.sort_by(|a, b| b.length().total_cmp(&a.length()));
        LineMap::new(lines)
    }
}

/// Where along a grid line the cells on both sides make a wall, each run with one side free.
fn runs(
    grid: &OccupancyGrid,
    count: usize,
    sides: impl Fn(usize) -> (Cell, Cell),
) -> Vec<[usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    let mut before = None;
    for k in 0..count {
        let (one, other) = sides(k);
        let wall = match (grid.occupancy(one), grid.occupancy(other)) {
            (Occupancy::Occupied, Occupancy::Free) => Some(true),
            (Occupancy::Free, Occupancy::Occupied) => Some(false),
            _ => None,
        };
        match runs.last_mut() {
            Some(run) if wall.is_some() && wall == before => run[1] = k + 1,
            _ if wall.is_some() => runs.push([k, k + 1]),
            _ => {}
        }
        before = wall;
    }
    runs
}
