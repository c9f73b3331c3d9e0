//! Lines and points drawn into a grid.

use crate::grid::{Cell, GridFrame, Occupancy, OccupancyGrid};
use crate::{Bounds, LineMap, LineSegment, PointMap, Result};
use loc_core::Pose2;
use loc_core::error::{non_negative, positive};
use nalgebra::Point2;

impl LineMap {
    /// A grid that just holds all lines, with `margin` \[m\] around them and cells of
    /// `resolution` \[m\]; see [`rasterize`](LineMap::rasterize).
    ///
    /// # Errors
    /// [`loc_core::Error`] for a resolution that is not positive, a negative margin, and for more
    /// cells than [`MAX_CELLS`](crate::grid::MAX_CELLS).
    pub fn to_grid(&self, resolution: f64, margin: f64) -> Result<OccupancyGrid> {
        Ok(self.rasterize(&frame_around(self.bounds(), resolution, margin)?))
    }

    /// The lines as a grid: occupied is every cell that a line touches, free every other.
    pub fn rasterize(&self, frame: &GridFrame) -> OccupancyGrid {
        let mut grid = OccupancyGrid::filled(*frame, Occupancy::Free.value());
        for line in self.lines() {
            visit_touched(frame, line, |cell| occupy(&mut grid, cell));
        }
        grid
    }
}

impl PointMap {
    /// A grid that just holds all points, with `margin` \[m\] around them and cells of
    /// `resolution` \[m\]; see [`rasterize`](PointMap::rasterize).
    ///
    /// # Errors
    /// As [`LineMap::to_grid`].
    pub fn to_grid(&self, resolution: f64, margin: f64) -> Result<OccupancyGrid> {
        Ok(self.rasterize(&frame_around(self.bounds(), resolution, margin)?))
    }

    /// The points as a grid: occupied is every cell that holds one, free every other.
    pub fn rasterize(&self, frame: &GridFrame) -> OccupancyGrid {
        let mut grid = OccupancyGrid::filled(*frame, Occupancy::Free.value());
        for point in self.points() {
            if let Some(cell) = frame.cell_at(point) {
                occupy(&mut grid, cell);
            }
        }
        grid
    }
}

fn occupy(grid: &mut OccupancyGrid, cell: Cell) {
    // It cannot fail: the cell is one of the grid's, and the value is a valid one.
    let _ = grid.set(cell, Occupancy::Occupied.value());
}

/// The frame of a grid around a box; one cell where there is no box.
fn frame_around(bounds: Option<Bounds>, resolution: f64, margin: f64) -> Result<GridFrame> {
    positive("resolution [m]", resolution)?;
    non_negative("margin around the map [m]", margin)?;
    let nothing = Bounds { min: Point2::origin(), max: Point2::origin() };
    let bounds = bounds.unwrap_or(nothing).grown(margin);
    // One cell more, because a line on the upper border touches the cell above it; a size beyond
    // all bounds saturates, and is refused by the frame.
    let cells = |extent: f64| ((extent / resolution).floor() as usize).saturating_add(1);
    let origin = Pose2::new(bounds.min.x, bounds.min.y, 0.0);
    GridFrame::new(cells(bounds.width()), cells(bounds.height()), resolution, origin)
}

/// Calls `visit` with every cell of the grid that a line touches, some twice.
///
/// The line is cut at the borders of the rows; within a row it covers all columns between its
/// ends there. Cells own their lower and left edges.
fn visit_touched(frame: &GridFrame, line: &LineSegment, mut visit: impl FnMut(Cell)) {
    let ends = [line.start, line.end].map(|end| frame.to_cells(&end));
    let [low, high] = if ends[0].y <= ends[1].y { ends } else { [ends[1], ends[0]] };
    let (rows, columns) = (frame.height() as f64, frame.width() as f64);
    if high.y < 0.0 || low.y >= rows {
        return;
    }
    let u_at = |v: f64| {
        let fraction = (v - low.y) / (high.y - low.y);
        low.x + (high.x - low.x) * fraction.clamp(0.0, 1.0)
    };
    // Within the grid's size, so that the casts are exact.
    let first = low.y.max(0.0) as usize;
    let last = (high.y as usize).min(frame.height() - 1);
    for row in first..=last {
        let (bottom, top) = (row as f64, row as f64 + 1.0);
        let enter = if low.y >= bottom { low.x } else { u_at(bottom) };
        let leave = if high.y <= top { high.x } else { u_at(top) };
        let (left, right) = (enter.min(leave), enter.max(leave));
        if right < 0.0 || left >= columns {
            continue;
        }
        let last = (right as usize).min(frame.width() - 1);
        for column in left.max(0.0) as usize..=last {
            visit(Cell::new(column, row));
        }
    }
}
