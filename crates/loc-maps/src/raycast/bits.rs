//! One bit a cell, in rows or in columns, read many cells at a time.

use crate::grid::{Cell, OCCUPIED_FROM, OccupancyGrid};

/// How many cells one reading holds, wherever it begins.
pub(super) const WINDOW: usize = 57;

/// Lines of bits: the rows of a grid, or its columns.
#[derive(Debug, Clone)]
pub(super) struct BitLines {
    bytes: Vec<u8>,
    /// From one line to the next \[bytes\].
    pub(super) stride: usize,
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
        lines: usize,
        place: impl Fn(Cell) -> (usize, usize),
    ) -> Self {
        // Eight bytes are read from any byte that holds a cell.
        let stride = length.div_ceil(8) + 8;
        let mut bytes = vec![0; stride * lines];
        for (cell, _) in grid.iter().filter(|&(_, value)| value >= OCCUPIED_FROM) {
            let (along, line) = place(cell);
            bytes[line * stride + along / 8] |= 1 << (along % 8);
        }
        BitLines { bytes, stride }
    }

    pub(super) fn bytes(&self) -> usize {
        self.bytes.len()
    }

    /// The cells from `from` on, in a line that begins at byte `line`: at least [`WINDOW`] of
    /// them, from the lowest bit up.
    #[inline(always)]
    pub(super) fn read(&self, line: usize, from: usize) -> u64 {
        let start = line + from / 8;
        let bytes = self.bytes.get(start..start + 8).and_then(|bytes| bytes.try_into().ok());
        u64::from_le_bytes(bytes.unwrap_or_default()) >> (from % 8)
    }
}
