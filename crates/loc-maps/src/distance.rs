//! Distance to the nearest obstacle, for every cell of a grid at once.
//!
//! A search of the nearest wall cell by cell would take minutes on a large map. The transform here
//! finds the exact Euclidean distances of all cells together, in time proportional to the number of
//! cells (Felzenszwalb and Huttenlocher, "Distance transforms of sampled functions", 2012): first
//! along the columns, then along the rows, where each column's distance defines a parabola and the
//! lower envelope of all parabolas is the result. Distances run from centre to centre and are kept
//! squared, in cells, as whole numbers, so nothing is rounded.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_maps::DistanceMap;
//! use loc_maps::grid::{Cell, GridFrame, OccupancyGrid};
//! let mut grid = OccupancyGrid::filled(GridFrame::new(50, 50, 0.1, Pose2::IDENTITY)?, 0);
//! grid.set(Cell::new(10, 10), 100)?;
//! let distances = DistanceMap::new(&grid, 2.0)?;
//! assert_eq!(distances.squared_cells(Cell::new(13, 14)), Some(25));
//! assert_eq!(distances.distance(Cell::new(13, 14)), Some(0.5));
//! assert_eq!(distances.distance(Cell::new(49, 49)), Some(2.0)); // beyond the cut-off
//! # Ok::<(), loc_maps::Error>(())
//! ```

use crate::Result;
use crate::grid::{Cell, GridFrame, Occupancy, OccupancyGrid};
use nalgebra::Point2;

/// The longest distance that is represented \[cells\].
pub const MAX_DISTANCE_CELLS: f64 = 32_767.0;

/// The distance of every cell of a grid to the nearest obstacle.
#[derive(Debug, Clone, PartialEq)]
pub struct DistanceMap {
    frame: GridFrame,
    max_distance: f64,
    /// The cut-off in whole cells, squared: nothing above it is stored.
    limit: u32,
    squared: Vec<u32>,
}

impl DistanceMap {
    /// The distances to the occupied cells of a grid, cut off at `max_distance` \[m\] (+inf for
    /// no cut-off; [`MAX_DISTANCE_CELLS`] is the limit anyway).
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a cut-off that is NaN or not above 0.
    pub fn new(grid: &OccupancyGrid, max_distance: f64) -> Result<Self> {
        let occupied = |value| Occupancy::of(value) == Occupancy::Occupied;
        DistanceMap::to_cells(grid, max_distance, occupied)
    }

    /// The same to the cells whose value `is_obstacle` accepts, for instance unknown ones too.
    ///
    /// # Errors
    /// As [`DistanceMap::new`].
    pub fn to_cells(
        grid: &OccupancyGrid,
        max_distance: f64,
        is_obstacle: impl Fn(i8) -> bool,
    ) -> Result<Self> {
        if max_distance.is_nan() || max_distance <= 0.0 {
            let (what, expected) = ("max_distance [m]", "a number > 0");
            return Err(loc_core::Error::OutOfRange { what, expected, found: max_distance }.into());
        }
        let frame = *grid.frame();
        let longest = (frame.width() as f64).hypot(frame.height() as f64).min(MAX_DISTANCE_CELLS);
        let reach = (max_distance / frame.resolution()).min(longest).ceil() as i16;
        let columns = distances(grid, reach, is_obstacle);
        let mut envelope = Envelope::new(frame.width(), reach);
        let mut squared = vec![0; frame.cell_count()];
        let rows = columns.chunks_exact(frame.width());
        for (row, out) in rows.zip(squared.chunks_exact_mut(frame.width())) {
            envelope.transform(row, out);
        }
        let limit = u32::from(reach.unsigned_abs()).pow(2);
        Ok(DistanceMap { frame, max_distance, limit, squared })
    }

    /// Size, resolution and origin of the grid.
    pub fn frame(&self) -> &GridFrame {
        &self.frame
    }

    /// The cut-off \[m\]: the distance of every cell that has no obstacle nearer than this.
    pub fn max_distance(&self) -> f64 {
        self.max_distance
    }

    /// The squared distances in row-major order, bottom row first \[cells^2\].
    pub fn squared(&self) -> &[u32] {
        &self.squared
    }

    /// Turns a stored squared distance \[cells^2\] into a distance, cut off \[m\].
    #[inline]
    pub fn to_metres(&self, squared: u32) -> f64 {
        if squared >= self.limit {
            return self.max_distance;
        }
        (f64::from(squared).sqrt() * self.frame.resolution()).min(self.max_distance)
    }

    /// The squared distance from a cell to the nearest obstacle \[cells^2\]; `None` outside the
    /// grid. Cut off at the whole number of cells at or above the cut-off.
    pub fn squared_cells(&self, cell: Cell) -> Option<u32> {
        self.squared.get(self.frame.index(cell)?).copied()
    }

    /// The distance from the centre of a cell to that of the nearest obstacle \[m\], `None`
    /// outside the grid.
    pub fn distance(&self, cell: Cell) -> Option<f64> {
        self.squared_cells(cell).map(|squared| self.to_metres(squared))
    }

    /// The distance of the cell at a point of the map \[m\], `None` outside the grid.
    pub fn distance_at(&self, point: &Point2<f64>) -> Option<f64> {
        self.distance(self.frame.cell_at(point)?)
    }

    /// The obstacle nearest to a cell, with its distance \[m\]; the first in row-major order where
    /// several are equally near. `None` outside the grid and beyond the cut-off.
    pub fn nearest_obstacle(&self, cell: Cell) -> Option<(Cell, f64)> {
        let squared = self.squared_cells(cell).filter(|&squared| squared < self.limit)?;
        let distance = self.to_metres(squared);
        if f64::from(squared).sqrt() * self.frame.resolution() > self.max_distance {
            return None;
        }
        // The distance is known, so only cells on one circle are candidates.
        let steps = u64::from(squared).isqrt() as isize;
        let across = |dy: isize| (i64::from(squared) - (dy * dy) as i64).unsigned_abs().isqrt();
        let on_circle = (-steps..=steps).flat_map(|dy| {
            let dx = across(dy) as isize;
            [(-dx, dy), (dx, dy)].into_iter().filter(move |_| {
                dx * dx + dy * dy == isize::try_from(squared).unwrap_or(isize::MAX)
            })
        });
        let obstacle = on_circle
            .filter_map(|(dx, dy)| {
                let column = cell.column.checked_add_signed(dx)?;
                Some(Cell::new(column, cell.row.checked_add_signed(dy)?))
            })
            .find(|&candidate| self.squared_cells(candidate) == Some(0));
        obstacle.map(|obstacle| (obstacle, distance))
    }
}

/// First pass: steps to the nearest obstacle up or down the column, at most `reach`, in row-major
/// order.
///
/// Whole rows are compared with their neighbour below, then above: no row depends on
/// itself, so the compiler vectorises over columns.
fn distances(grid: &OccupancyGrid, reach: i16, is_obstacle: impl Fn(i8) -> bool) -> Vec<i16> {
    let width = grid.width();
    // The predicate is evaluated once per value, not once per cell.
    let table: [i16; 256] =
        std::array::from_fn(|byte| if is_obstacle(byte as u8 as i8) { 0 } else { reach });
    let start = grid.values().iter().map(|&value| table[usize::from(value as u8)]);
    let mut steps: Vec<i16> = start.collect();
    let mut upward = steps.chunks_exact_mut(width);
    let mut below = upward.next();
    for row in upward {
        if let Some(below) = below {
            advance(row, below);
        }
        below = Some(row);
    }
    let mut downward = steps.chunks_exact_mut(width).rev();
    let mut above = downward.next();
    for row in downward {
        if let Some(above) = above {
            advance(row, above);
        }
        above = Some(row);
    }
    steps
}

fn advance(row: &mut [i16], neighbour: &[i16]) {
    for (steps, &beside) in row.iter_mut().zip(neighbour) {
        *steps = (*steps).min(beside.saturating_add(1));
    }
}

/// A parabola `(x - at)^2 + height` that is lowest from `from` on.
#[derive(Debug, Clone, Copy)]
struct Parabola {
    at: i32,
    height: i32,
    from: f64,
}

/// Second pass, along rows: the lower envelope of the columns' parabolas, with its buffers.
#[derive(Debug)]
struct Envelope {
    reach: i16,
    /// 1 / (2 d), by the distance d of two parabolas.
    halved_inverse: Vec<f64>,
    lowest: Vec<Parabola>,
}

impl Envelope {
    fn new(width: usize, reach: i16) -> Self {
        let spans = width.min(2 * usize::from(reach.unsigned_abs()) + 1);
        let halved_inverse = (0..=spans).map(|span| 0.5 / span as f64).collect();
        Envelope { reach, halved_inverse, lowest: Vec::with_capacity(width) }
    }

    /// Squared distances of a row from the steps along its columns, at most `reach` squared.
    fn transform(&mut self, steps: &[i16], squared: &mut [u32]) {
        self.lowest.clear();
        for (at, &step) in steps.iter().enumerate() {
            if step < self.reach {
                self.push(at as i32, i32::from(step) * i32::from(step));
            }
        }
        self.fill(squared);
    }

    /// Adds the next parabola to the right; those that it hides are removed.
    fn push(&mut self, at: i32, height: i32) {
        let mut from = f64::NEG_INFINITY;
        while let Some(last) = self.lowest.last() {
            let span = (at - last.at) as usize;
            let middle = 0.5 * (f64::from(at) + f64::from(last.at));
            // Parabolas farther apart than the table reaches meet beyond the cut-off of both.
            let inverse = self.halved_inverse.get(span).copied().unwrap_or(0.0);
            from = middle + f64::from(height - last.height) * inverse;
            if from > last.from {
                break;
            }
            self.lowest.pop();
            from = f64::NEG_INFINITY;
        }
        self.lowest.push(Parabola { at, height, from });
    }

    fn fill(&self, squared: &mut [u32]) {
        let reach = i32::from(self.reach);
        let limit = reach * reach;
        let width = squared.len();
        let mut done = 0;
        for (k, parabola) in self.lowest.iter().enumerate() {
            let until = self.lowest.get(k + 1).map_or(width as f64, |next| next.from.ceil());
            let end = (until.max(0.0) as usize).min(width);
            // Only this part of the parabola lies below the cut-off.
            let left = ((parabola.at - reach).max(0) as usize).clamp(done, done.max(end));
            let right = ((parabola.at + reach + 1) as usize).clamp(left, left.max(end));
            squared[done..left].fill(limit as u32);
            for (x, out) in (left as i32..).zip(&mut squared[left..right]) {
                let dx = x - parabola.at;
                *out = (dx * dx + parabola.height).min(limit) as u32;
            }
            done = right;
            if end > done {
                squared[done..end].fill(limit as u32);
                done = end;
            }
        }
        squared[done..].fill(limit as u32);
    }
}
