//! One bit a cell, in rows or in columns, read many cells at a time.

use crate::grid::{Cell, OCCUPIED_FROM, OccupancyGrid};

/// How many cells one reading holds, wherever it begins.
pub(super) const WINDOW: usize = 57;

/// Lines in a group.
pub(super) const GROUP: usize = 4;

/// Cells of wall before the first cell of a line: no reading backwards reaches below them.
pub(super) const MARGIN: usize = 64;

/// Lines of bits, the rows of a grid or its columns, with a wall all round.
///
/// The wall saves the search from asking at every step whether the ray has left the grid: it is
/// [`MARGIN`] cells deep before and after every line, and one group of lines below and above.
#[derive(Debug, Clone)]
pub(super) struct BitLines {
    /// The lines, and what any line of a group holds.
    lines: Vec<u8>,
    groups: Vec<u8>,
    /// From one line to the next \[bytes\].
    stride: usize,
}

impl BitLines {
    /// The rows of a grid.
    pub(super) fn rows(grid: &OccupancyGrid) -> Self {
        BitLines::new(grid, grid.width(), grid.height(), |cell| (cell.column, cell.row))
    }

    /// The columns of a grid.
    pub(super) fn columns(grid: &OccupancyGrid) -> Self {
        BitLines::new(grid, grid.height(), grid.width(), |cell| (cell.row, cell.column))
    }

    fn new(
        grid: &OccupancyGrid,
        length: usize,
        count: usize,
        place: impl Fn(Cell) -> (usize, usize),
    ) -> Self {
        let stride = (length + 2 * MARGIN).div_ceil(8) + 8;
        let count = count.next_multiple_of(GROUP) + 2 * GROUP;
        let mut lines = vec![u8::MAX; stride * count];
        for (cell, value) in grid.iter() {
            let (along, line) = place(cell);
            let (along, line) = (along + MARGIN, line + GROUP);
            if value < OCCUPIED_FROM {
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

    pub(super) fn bytes(&self) -> usize {
        self.lines.len() + self.groups.len()
    }

    /// The cells of a line from `from` on, at least [`WINDOW`] of them, from the lowest bit up.
    #[inline(always)]
    pub(super) fn line(&self, line: usize, from: usize) -> u64 {
        read(&self.lines, line * self.stride, from)
    }

    /// The same of a group of lines together.
    #[inline(always)]
    pub(super) fn group(&self, group: usize, from: usize) -> u64 {
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
