//! Rays through lines of bits: all the cells that a ray passes in a line are looked at together.

use super::GridRay;
use super::bits::{BitLines, WINDOW};
use crate::grid::{GridFrame, OccupancyGrid};
use loc_sensors::world::RangeWorld;
use nalgebra::Point2;

/// A grid prepared for casting many rays.
///
/// It keeps one bit a cell, once by rows and once by columns (a quarter of a byte a cell in all).
/// A ray that runs more along x than along y passes a run of neighbouring cells in each row; one
/// reading of eight bytes holds the run, and the first bit set in it is the wall. Steep rays do
/// the same over columns. The answers are those of the exact traversal.
#[derive(Debug, Clone)]
pub struct RayCaster {
    frame: GridFrame,
    /// Rows for rays that run along x, columns for those along y.
    lines: [BitLines; 2],
}

/// The part of a ray that the search needs: `major` is the axis that it runs along.
struct Search<'a> {
    lines: &'a BitLines,
    /// The line that the ray starts in, and how many it crosses.
    first_line: usize,
    crossed: usize,
    upward: bool,
    /// The cells along the lines where it starts and ends.
    first: usize,
    last: usize,
    /// Where it leaves the first line, and how far it runs in each \[cells, in fractions\].
    leaving: i64,
    run: i64,
    fraction_bits: u32,
}

impl RayCaster {
    /// Prepares the occupied cells of a grid.
    pub fn new(grid: &OccupancyGrid) -> Self {
        RayCaster { frame: *grid.frame(), lines: [BitLines::rows(grid), BitLines::columns(grid)] }
    }

    /// Size, resolution and origin of the grid.
    pub fn frame(&self) -> &GridFrame {
        &self.frame
    }

    /// Memory of the prepared grid \[bytes\].
    pub fn bytes(&self) -> usize {
        self.lines.iter().map(BitLines::bytes).sum()
    }

    /// The length at which a ray meets its first occupied cell \[cells\].
    #[inline]
    fn cast_in_cells(&self, ray: &GridRay) -> Option<f64> {
        let major = usize::from(ray.direction[0].abs() < ray.direction[1].abs());
        let minor = 1 - major;
        let size = [self.frame.width(), self.frame.height()];
        let cell = |axis: usize, length: f64| ray.cell(axis, length, size[axis]);
        let (first_line, last_line) = (cell(minor, ray.enter), cell(minor, ray.leave));
        let upward = ray.direction[minor] >= 0.0;
        let fraction_bits = 60 - size[major].ilog2();
        let unit = (1_u64 << fraction_bits) as f64;
        let longest = size[major] as f64 + 1.0;
        // Finite for rays along the lines too, so that nothing times it is NaN.
        let run = (ray.direction[major] * ray.inverse[minor]).abs().min(1e100);
        let run = run.copysign(ray.direction[major]);
        let edge = if upward { first_line + 1 } else { first_line } as f64;
        let lines_off = (edge - ray.start[minor]).abs();
        let leaving = (ray.start[major] + lines_off * run).clamp(-longest, 2.0 * longest);
        let search = Search {
            lines: &self.lines[major],
            first_line,
            crossed: first_line.abs_diff(last_line),
            upward,
            first: cell(major, ray.enter),
            last: cell(major, ray.leave),
            leaving: (leaving * unit) as i64,
            run: (run.clamp(-longest, longest) * unit) as i64,
            fraction_bits,
        };
        let (line, along) = match (ray.direction[major] >= 0.0, run.abs() < (WINDOW - 2) as f64) {
            (true, true) => search.along::<true, true>(),
            (false, true) => search.along::<false, true>(),
            (true, false) => search.along::<true, false>(),
            (false, false) => search.along::<false, false>(),
        }?;
        let hit = if major == 0 { [along, line] } else { [line, along] };
        Some(ray.entry_of(hit))
    }
}

impl Search<'_> {
    /// The line and the cell in it that the ray meets first. `SHORT`: a run fits one reading.
    #[inline]
    fn along<const FORWARD: bool, const SHORT: bool>(&self) -> Option<(usize, usize)> {
        let stride = self.lines.stride;
        let step = if self.upward { stride } else { stride.wrapping_neg() };
        let mut line = self.first_line * stride;
        let (mut from, mut leaving) = (self.first, self.leaving);
        for crossed in 0..=self.crossed {
            let there = (leaving >> self.fraction_bits).max(0) as usize;
            let to = match (FORWARD, crossed == self.crossed) {
                (_, true) => self.last,
                (true, _) => there.min(self.last),
                (false, _) => there.max(self.last),
            };
            let found = if SHORT {
                self.first_in_window::<FORWARD>(line, from, to)
            } else {
                self.first_in_run::<FORWARD>(line, from, to)
            };
            if let Some(along) = found {
                return Some((line / stride, along));
            }
            from = to;
            leaving = leaving.wrapping_add(self.run);
            line = line.wrapping_add(step);
        }
        None
    }

    /// The first cell set from `from` to `to`, which one reading holds.
    #[inline(always)]
    fn first_in_window<const FORWARD: bool>(
        &self,
        line: usize,
        from: usize,
        to: usize,
    ) -> Option<usize> {
        let lowest = if FORWARD { from } else { to };
        let cells = if FORWARD { to.wrapping_sub(from) } else { from.wrapping_sub(to) } & 63;
        let set = self.lines.read(line, lowest) & (u64::MAX >> (63 - cells));
        if set == 0 {
            return None;
        }
        let bit = if FORWARD { set.trailing_zeros() } else { 63 - set.leading_zeros() };
        Some(lowest + bit as usize)
    }

    /// The same for runs of any length, one reading after the other.
    fn first_in_run<const FORWARD: bool>(
        &self,
        line: usize,
        mut from: usize,
        to: usize,
    ) -> Option<usize> {
        loop {
            let end = if FORWARD {
                to.min(from + WINDOW - 1)
            } else {
                to.max(from.saturating_sub(WINDOW - 1))
            };
            let found = self.first_in_window::<FORWARD>(line, from, end);
            if found.is_some() || end == to {
                return found;
            }
            from = end;
        }
    }
}

impl RangeWorld for RayCaster {
    fn cast(&self, origin: &Point2<f64>, direction: f64, max_range: f64) -> Option<f64> {
        let (sin, cos) = direction.sin_cos();
        let ray = GridRay::new(&self.frame, origin, [cos, sin], max_range)?;
        Some(self.cast_in_cells(&ray)? * self.frame.resolution())
    }
}
