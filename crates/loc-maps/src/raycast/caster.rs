//! Rays through lines of bits: all the cells that a ray passes in a line are looked at together.

use super::GridRay;
use super::bits::{BitLines, GROUP, MARGIN};
use super::ray::fan;
use super::search::Search;
use crate::grid::{GridFrame, OccupancyGrid};
use loc_sensors::world::RangeWorld;
use nalgebra::Point2;

/// A grid prepared for casting many rays.
///
/// It keeps one bit a cell, once by rows and once by columns, and for each four lines what any of
/// them holds (a third of a byte a cell in all). A ray that runs more along x than along y passes
/// a run of neighbouring cells in each row; one reading of eight bytes holds the runs of four
/// rows, and only where something is set there the rows are looked at one by one. Steep rays do
/// the same over columns. The answers are those of the exact traversal.
#[derive(Debug, Clone)]
pub struct RayCaster {
    frame: GridFrame,
    /// Rows for rays that run along x, columns for those along y.
    lines: [BitLines; 2],
    fraction_bits: u32,
}

impl RayCaster {
    /// Prepares the occupied cells of a grid.
    pub fn new(grid: &OccupancyGrid) -> Self {
        let frame = *grid.frame();
        let longest = frame.width().max(frame.height()) + 4 * MARGIN;
        let fraction_bits = 58 - longest.ilog2();
        let lines = [BitLines::rows(grid), BitLines::columns(grid)];
        RayCaster { frame, lines, fraction_bits }
    }

    /// Size, resolution and origin of the grid.
    pub fn frame(&self) -> &GridFrame {
        &self.frame
    }

    /// Memory of the prepared grid \[bytes\].
    pub fn bytes(&self) -> usize {
        self.lines.iter().map(BitLines::bytes).sum()
    }

    /// The length at which a ray meets its first occupied cell, `None` where there is none within
    /// `max_length`. All in the grid's frame \[cells\], the direction a unit vector: for loops that
    /// turn directions themselves instead of asking for sine and cosine at every ray.
    #[inline(always)]
    pub fn cast_in_cells(
        &self,
        start: [f64; 2],
        direction: [f64; 2],
        max_length: f64,
    ) -> Option<f64> {
        let size = [self.frame.width(), self.frame.height()];
        let is_inside = |axis: usize| start[axis] >= 0.0 && start[axis] < size[axis] as f64;
        let ray = if is_inside(0) && is_inside(1) {
            // Any end will do: the wall round the grid ends the search.
            let inverse = direction.map(|component| 1.0 / component);
            GridRay { start, direction, inverse, enter: 0.0, leave: max_length }
        } else {
            GridRay::in_cells(&self.frame, start, direction, max_length)?
        };
        let major = usize::from(direction[0].abs() < direction[1].abs());
        let (line, cell) = self.search(&ray, major).first_hit()?;
        let (line, cell) = (line.wrapping_sub(GROUP), cell.wrapping_sub(MARGIN));
        let hit = if major == 0 { [cell, line] } else { [line, cell] };
        if hit[0] >= size[0] || hit[1] >= size[1] {
            return None;
        }
        Some(ray.entry_of(hit)).filter(|&length| length <= max_length)
    }

    #[inline(always)]
    fn search(&self, ray: &GridRay, major: usize) -> Search<'_> {
        let minor = 1 - major;
        let size = [self.frame.width(), self.frame.height()];
        let (cell, line) =
            (ray.cell(major, ray.enter, size[major]), ray.cell(minor, ray.enter, size[minor]));
        let upward = ray.direction[minor] >= 0.0;
        let edge = if upward { line + 1 } else { line } as f64;
        // Finite for rays along the lines too, so that nothing times it is NaN.
        let slope = (ray.direction[major] * ray.inverse[minor]).abs().min(1e100);
        let run = slope.copysign(ray.direction[major]);
        let longest = (size[major] + MARGIN) as f64;
        let leaving = ray.start[major] + (edge - ray.start[minor]).abs() * run;
        // The wall lies within these, and so do all readings.
        let leaving = leaving.clamp(-(MARGIN as f64) + 1.0, longest) + MARGIN as f64;
        let unit = (1_u64 << self.fraction_bits) as f64;
        Search {
            lines: &self.lines[major],
            line: line + GROUP,
            cell: cell + MARGIN,
            crossed: (((ray.leave - ray.enter) * ray.direction[minor].abs()) as usize)
                .saturating_add(1),
            upward,
            leaving: (leaving * unit) as i64,
            run: (run.clamp(-longest, longest) * unit) as i64,
            fraction_bits: self.fraction_bits,
        }
    }
}

impl RangeWorld for RayCaster {
    fn cast(&self, origin: &Point2<f64>, direction: f64, max_range: f64) -> Option<f64> {
        if !direction.is_finite() {
            return None;
        }
        let start = self.frame.to_cells(origin);
        let (sin, cos) = direction.sin_cos();
        let along = self.frame.turn_to_grid([cos, sin]);
        let max_length = max_range / self.frame.resolution();
        let length = self.cast_in_cells([start.x, start.y], along, max_length)?;
        Some(length * self.frame.resolution())
    }

    fn cast_fan(
        &self,
        origin: &Point2<f64>,
        first: f64,
        increment: f64,
        max_range: f64,
        ranges: &mut [f64],
    ) {
        let Point2 { coords } = self.frame.to_cells(origin);
        let (start, resolution) = ([coords.x, coords.y], self.frame.resolution());
        fan(&self.frame, first, increment, ranges, |along| {
            Some(self.cast_in_cells(start, along, max_range / resolution)? * resolution)
        });
    }
}
