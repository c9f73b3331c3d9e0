//! Ray casting on lines of bits: all the cells of a ray in one line are tested together.

use super::GridRay;
use super::traversal::fan;
use crate::grid::{Cell, GridFrame, OCCUPIED_FROM, Occupancy, OccupancyGrid};
use loc_sensors::world::RangeWorld;
use nalgebra::Point2;

/// A grid prepared for casting many rays.
///
/// It keeps one bit a cell, once by rows and once by columns, and for each four lines their
/// union (a third of a byte a cell in all). A ray that runs more along x than along y passes
/// a run of neighbouring cells in each row; one reading of eight bytes holds the runs of four
/// rows, and only where a bit is set there the rows are tested one by one. Steep rays do
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
        RayCaster::stopping_at(grid, |value| value >= OCCUPIED_FROM)
    }

    /// The same for rays that stop at unknown cells as well: within the known free space.
    pub fn within_known(grid: &OccupancyGrid) -> Self {
        RayCaster::stopping_at(grid, |value| Occupancy::of(value) != Occupancy::Free)
    }

    fn stopping_at(grid: &OccupancyGrid, stops: impl Fn(i8) -> bool) -> Self {
        let frame = *grid.frame();
        let longest = frame.width().max(frame.height()) + 4 * MARGIN;
        let fraction_bits = 58 - longest.ilog2();
        let lines = [BitLines::rows(grid, &stops), BitLines::columns(grid, &stops)];
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
    /// rotate directions themselves instead of computing sine and cosine for every ray.
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

/// How many cells one reading holds, wherever it begins.
const WINDOW: usize = 57;

/// Lines in a group.
const GROUP: usize = 4;

/// Cells of wall before the first cell of a line: no reading backwards reaches below them.
const MARGIN: usize = 64;

/// Lines of bits, the rows of a grid or its columns, with a wall all round.
///
/// With the wall the search needs no test of whether the ray has left the grid: it is
/// [`MARGIN`] cells deep before and after every line, and one group of lines below and above.
#[derive(Debug, Clone)]
struct BitLines {
    /// The lines, and the union of the lines of each group.
    lines: Vec<u8>,
    groups: Vec<u8>,
    /// From one line to the next \[bytes\].
    stride: usize,
}

impl BitLines {
    /// The rows of a grid.
    fn rows(grid: &OccupancyGrid, stops: impl Fn(i8) -> bool) -> Self {
        BitLines::new(grid, grid.width(), grid.height(), |cell| (cell.column, cell.row), stops)
    }

    /// The columns of a grid.
    fn columns(grid: &OccupancyGrid, stops: impl Fn(i8) -> bool) -> Self {
        BitLines::new(grid, grid.height(), grid.width(), |cell| (cell.row, cell.column), stops)
    }

    fn new(
        grid: &OccupancyGrid,
        length: usize,
        count: usize,
        place: impl Fn(Cell) -> (usize, usize),
        stops: impl Fn(i8) -> bool,
    ) -> Self {
        let stride = (length + 2 * MARGIN).div_ceil(8) + 8;
        let count = count.next_multiple_of(GROUP) + 2 * GROUP;
        let mut lines = vec![u8::MAX; stride * count];
        for (cell, value) in grid.iter() {
            let (along, line) = place(cell);
            let (along, line) = (along + MARGIN, line + GROUP);
            if !stops(value) {
                lines[line * stride + along / 8] &= !(1 << (along % 8));
            }
        }
        let group = |lines: &[u8]| {
            (0..stride)
                .map(|k| (0..GROUP).fold(0, |all, line| all | lines[line * stride + k]))
                .collect::<Vec<u8>>()
        };
        let groups = lines.chunks_exact(GROUP * stride).flat_map(group).collect();
        BitLines { lines, groups, stride }
    }

    fn bytes(&self) -> usize {
        self.lines.len() + self.groups.len()
    }

    /// The cells of a line from `from` on, at least [`WINDOW`] of them, from the lowest bit up.
    #[inline(always)]
    fn line(&self, line: usize, from: usize) -> u64 {
        read(&self.lines, line * self.stride, from)
    }

    /// The same of a group of lines together.
    #[inline(always)]
    fn group(&self, group: usize, from: usize) -> u64 {
        read(&self.groups, group * self.stride, from)
    }
}

#[inline(always)]
fn read(bytes: &[u8], line: usize, from: usize) -> u64 {
    let start = line.wrapping_add(from / 8);
    let eight = bytes.get(start..start.wrapping_add(8)).and_then(|bytes| bytes.try_into().ok());
    // What cannot be read is wall.
    eight.map_or(u64::MAX, u64::from_le_bytes) >> (from % 8)
}

/// A ray among lines: it runs more along them than across.
///
/// Positions along the lines are whole numbers with `fraction_bits` binary places, so that the
/// cells of a group of lines are exactly those of its lines.
#[derive(Debug)]
struct Search<'a> {
    lines: &'a BitLines,
    /// The line that the ray starts in, and the cell there.
    line: usize,
    cell: usize,
    /// How many lines it crosses at most.
    crossed: usize,
    upward: bool,
    /// Where it leaves the first line, and how far it runs in each line.
    leaving: i64,
    run: i64,
    fraction_bits: u32,
}

impl Search<'_> {
    /// The line and the cell in it that the ray meets first; `None` where it ends before.
    #[inline(always)]
    fn first_hit(&self) -> Option<(usize, usize)> {
        // A reading holds the cells of a group, of a line, or only a part of them.
        let run = (self.run.unsigned_abs() >> self.fraction_bits) as usize;
        match (self.run >= 0, run) {
            (true, ..GROUP_RUN) => self.by_groups::<true>(),
            (false, ..GROUP_RUN) => self.by_groups::<false>(),
            (true, ..LINE_RUN) => self.by_lines::<true, true>(0, self.crossed),
            (false, ..LINE_RUN) => self.by_lines::<false, true>(0, self.crossed),
            (true, _) => self.by_lines::<true, false>(0, self.crossed),
            (false, _) => self.by_lines::<false, false>(0, self.crossed),
        }
    }

    /// Group after group, and line after line where a group holds something near the ray.
    #[inline(always)]
    fn by_groups<const FORWARD: bool>(&self) -> Option<(usize, usize)> {
        let within = self.line % GROUP;
        let rest = if self.upward { GROUP - 1 - within } else { within };
        let mut group = self.line / GROUP;
        let (mut from, mut leaving) = (self.cell, self.leaving + rest as i64 * self.run);
        let (step, run) = (if self.upward { 1 } else { usize::MAX }, GROUP as i64 * self.run);
        // The first and the last line of the part of the ray in this group, counted from its start.
        let mut first = 0;
        let mut last = rest;
        while first <= self.crossed {
            let to = (leaving >> self.fraction_bits) as usize;
            let lowest = if FORWARD { from } else { to };
            let set = self.lines.group(group, lowest) & span::<FORWARD>(from, to);
            if set != 0 {
                let hit = self.by_lines::<FORWARD, true>(first, last);
                if hit.is_some() {
                    return hit;
                }
            }
            (from, leaving) = (to, leaving + run);
            group = group.wrapping_add(step);
            (first, last) = (last + 1, last + GROUP);
        }
        None
    }

    /// Line after line, from the `first` that the ray passes to the `last`. `SHORT`: a reading
    /// holds all cells of the ray in a line.
    #[inline(always)]
    fn by_lines<const FORWARD: bool, const SHORT: bool>(
        &self,
        first: usize,
        last: usize,
    ) -> Option<(usize, usize)> {
        let mut leaving = self.leaving + first as i64 * self.run;
        let before = ((leaving - self.run) >> self.fraction_bits) as usize;
        let mut from = if first == 0 { self.cell } else { before };
        for passed in first..=last {
            // A long run may end below the wall before the line.
            let to = leaving >> self.fraction_bits;
            let to = if SHORT { to } else { to.max(0) } as usize;
            let line =
                if self.upward { self.line + passed } else { self.line.wrapping_sub(passed) };
            let found = if SHORT {
                self.in_window::<FORWARD>(line, from, to)
            } else {
                self.in_run::<FORWARD>(line, from, to)
            };
            if let Some(cell) = found {
                return Some((line, cell));
            }
            (from, leaving) = (to, leaving + self.run);
        }
        None
    }

    /// The first cell set from `from` to `to`, which one reading holds.
    #[inline(always)]
    fn in_window<const FORWARD: bool>(&self, line: usize, from: usize, to: usize) -> Option<usize> {
        let lowest = if FORWARD { from } else { to };
        let set = self.lines.line(line, lowest) & span::<FORWARD>(from, to);
        let bit = if FORWARD { set.trailing_zeros() } else { 63 - (set | 1).leading_zeros() };
        (set != 0).then_some(lowest + bit as usize)
    }

    /// The same for runs of any length, one reading after the other.
    fn in_run<const FORWARD: bool>(
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
            let found = self.in_window::<FORWARD>(line, from, end);
            if found.is_some() || end == to {
                return found;
            }
            from = end;
        }
    }
}

/// The longest run in a line for which a reading holds all cells of a group.
const GROUP_RUN: usize = (WINDOW - 2) / GROUP - 1;

/// The longest run for which a reading holds all cells of a line.
const LINE_RUN: usize = WINDOW - 2;

/// The lowest bits, as many as there are cells from `from` to `to`.
#[inline(always)]
fn span<const FORWARD: bool>(from: usize, to: usize) -> u64 {
    let cells = if FORWARD { to.wrapping_sub(from) } else { from.wrapping_sub(to) };
    u64::MAX >> (63_usize.wrapping_sub(cells) & 63)
}
