//! From one kind of map to another, where that has a meaning.
//!
//! An architect's drawing becomes a grid for a particle filter, a grid that a robot has built
//! becomes lines to match against, and everything becomes points for scan matching:
//!
//! | from | to | by |
//! |---|---|---|
//! | lines, points | grid | [`LineMap::to_grid`], [`LineMap::rasterize`], [`PointMap::to_grid`], [`PointMap::rasterize`] |
//! | grid | points | [`PointMap::from_grid`] |
//! | grid | lines | [`LineMap::from_grid`], [`LineMap::outline`] |
//! | lines | points | [`PointMap::from_lines`] |
//! | scans with poses | points | [`PointMap::from_scans`] |
//! | grid | places | [`TopologicalMap::from_grid`](crate::TopologicalMap::from_grid) |
//! | all | SVG picture | [`MapPicture`](crate::MapPicture) |
//!
//! ```
//! use loc_maps::convert::Surface;
//! use loc_maps::{LineMap, PointMap};
//! let room = LineMap::parse_csv("room.csv", "0,0,4,0\n4,0,4,3\n4,3,0,3\n0,3,0,0\n")?;
//! let grid = room.to_grid(0.05, 0.5)?;
//! let points = PointMap::from_grid(&grid, Surface::Boundary)?;
//! assert_eq!(points.len(), grid.counts().occupied);
//!
//! let again = LineMap::from_grid(&grid, &Default::default())?;
//! assert_eq!(again.len(), 4);
//! # Ok::<(), loc_maps::Error>(())
//! ```
//!
//! [`LineMap::to_grid`]: crate::LineMap::to_grid
//! [`LineMap::rasterize`]: crate::LineMap::rasterize
//! [`LineMap::from_grid`]: crate::LineMap::from_grid
//! [`LineMap::outline`]: crate::LineMap::outline
//! [`PointMap::to_grid`]: crate::PointMap::to_grid
//! [`PointMap::rasterize`]: crate::PointMap::rasterize
//! [`PointMap::from_grid`]: crate::PointMap::from_grid
//! [`PointMap::from_lines`]: crate::PointMap::from_lines
//! [`PointMap::from_scans`]: crate::PointMap::from_scans

mod vectorize;

pub use vectorize::VectorizeSettings;

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

/// The occupied cells of a grid, or only those next to a free one.
fn surface_cells(grid: &OccupancyGrid, surface: Surface) -> impl Iterator<Item = Cell> + '_ {
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
