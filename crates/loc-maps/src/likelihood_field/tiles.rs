//! Bytes of a grid in tiles of 8 x 8, with a margin of one tile all round.

use super::View;
use super::rating::BLOCK;
use crate::grid::{Cell, GridFrame};
use nalgebra::Point2;

/// Side of a tile \[cells\]; the margin is as wide.
const SIDE: usize = 8;

/// The bits of a number in single precision that hold its digits.
const MANTISSA: u32 = (1 << (f32::MANTISSA_DIGITS - 1)) - 1;

/// Size of a cache line \[bytes\], equal to a tile.
const LINE: usize = SIDE * SIDE;

/// Longest side of a grid for coordinates in single precision \[cells\]: at its
/// far end they are rounded to 1/64 of a cell.
pub(super) const MAX_SIDE: usize = 1 << 18;

#[derive(Debug)]
pub(super) struct Tiles {
    /// The codes tile by tile, from `start` on, so that tiles begin where cache lines do.
    codes: Vec<u8>,
    start: usize,
    tiles_per_row: u32,
    /// The last column and row, margin included.
    last: [f32; 2],
    /// Added to a coordinate, it leaves the whole cells at fixed bits of the number: a power of
    /// two above every coordinate. A conversion to integers would cost three times as much.
    anchor: f32,
    /// How many bits of the fraction stand below those.
    fraction_bits: u32,
}

impl Tiles {
    /// Tiles for a grid with sides up to [`MAX_SIDE`], filled with the code of what lies off
    /// the map.
    pub(super) fn new(width: usize, height: usize, off_map: u8) -> Self {
        let [across, up] = [width, height].map(|cells| cells.div_ceil(SIDE) + 2);
        let last = [across, up].map(|tiles| (tiles * SIDE - 1) as f32);
        let (codes, start) = aligned(across * up * LINE, off_map);
        // At most eight bits of fraction, so that 2.999 stays below 3.
        let whole_bits = (across.max(up) * SIDE).ilog2() + 1;
        let fraction_bits = f32::MANTISSA_DIGITS.saturating_sub(1 + whole_bits).min(8);
        let anchor = (1_u32 << (f32::MANTISSA_DIGITS - 1 - fraction_bits)) as f32;
        Tiles { codes, start, tiles_per_row: across as u32, last, anchor, fraction_bits }
    }

    pub(super) fn bytes(&self) -> usize {
        self.codes.len()
    }

    /// Sets the code of a cell of the grid.
    pub(super) fn set(&mut self, column: usize, row: usize, code: u8) {
        let place = self.place((column + SIDE) as u32, (row + SIDE) as u32) as usize;
        if let Some(place) = self.codes.get_mut(self.start + place) {
            *place = code;
        }
    }

    /// The code of a cell of the grid; of one it does not have, 0.
    pub(super) fn get(&self, column: usize, row: usize) -> u8 {
        let place = self.place((column + SIDE) as u32, (row + SIDE) as u32) as usize;
        self.codes.get(self.start + place).copied().unwrap_or_default()
    }

    /// The codes in the order of the places.
    #[inline(always)]
    pub(super) fn codes(&self) -> &[u8] {
        self.codes.get(self.start..).unwrap_or_default()
    }

    /// The place of a point of the grid's frame \[cells\], on the map or off it.
    pub(super) fn place_of(&self, u: f64, v: f64) -> u32 {
        self.place_at(u as f32 + SIDE as f32, v as f32 + SIDE as f32)
    }

    /// The places of the cells in which the beams of a block end.
    #[inline(always)]
    pub(super) fn places(
        &self,
        view: View,
        (xs, ys): (&[f32; BLOCK], &[f32; BLOCK]),
    ) -> [u32; BLOCK] {
        let view = View { u: view.u + SIDE as f32, v: view.v + SIDE as f32, ..view };
        let mut places = [0; BLOCK];
        for (place, (&x, &y)) in places.iter_mut().zip(xs.iter().zip(ys)) {
            let (u, v) = view.end(x, y);
            *place = self.place_at(u, v);
        }
        places
    }

    /// The place of a cell by coordinates from the corner of the margin; what lies outside,
    /// however far, and NaN end up in the margin.
    #[inline(always)]
    fn place_at(&self, u: f32, v: f32) -> u32 {
        // In this form NaN fails both comparisons and one instruction does each of them.
        let clamp = |x: f32, last: f32| {
            let x = if x > 0.0 { x } else { 0.0 };
            if x < last { x } else { last }
        };
        let whole = |x: f32| ((x + self.anchor).to_bits() & MANTISSA) >> self.fraction_bits;
        self.place(whole(clamp(u, self.last[0])), whole(clamp(v, self.last[1])))
    }

    #[inline(always)]
    fn place(&self, column: u32, row: u32) -> u32 {
        let tile = (row / 8) * self.tiles_per_row + column / 8;
        tile * LINE as u32 + (row % 8) * 8 + column % 8
    }
}

impl Clone for Tiles {
    /// The copy's tiles begin where cache lines do in its own memory.
    fn clone(&self) -> Self {
        let tiles = self.codes.len() - LINE;
        let (mut codes, start) = aligned(tiles, 0);
        codes[start..start + tiles].copy_from_slice(&self.codes[self.start..self.start + tiles]);
        Tiles { codes, start, ..*self }
    }
}

/// Memory of one line more than requested, and the offset of its first whole line.
fn aligned(bytes: usize, value: u8) -> (Vec<u8>, usize) {
    let codes = vec![value; bytes + LINE];
    let start = codes.as_ptr().align_offset(LINE).min(LINE);
    (codes, start)
}

/// One byte a cell.
#[derive(Debug, Clone)]
pub(super) enum Codes {
    /// Of a map of ordinary size.
    Tiles(Tiles),
    /// Of a map with so long a side that single precision cannot resolve its cells (13 km at
    /// 5 cm): row by row, and after the last cell the code of what lies off the map.
    Rows(Vec<u8>),
}

impl Codes {
    /// Room for the codes of a grid, filled with that of what lies off the map.
    pub(super) fn new(frame: &GridFrame, off_map: u8) -> Self {
        if frame.width().max(frame.height()) <= MAX_SIDE {
            Codes::Tiles(Tiles::new(frame.width(), frame.height(), off_map))
        } else {
            Codes::Rows(vec![off_map; frame.cell_count() + 1])
        }
    }

    pub(super) fn bytes(&self) -> usize {
        match self {
            Codes::Tiles(tiles) => tiles.bytes(),
            Codes::Rows(codes) => codes.len(),
        }
    }

    /// Sets the code of a cell of the grid.
    pub(super) fn set(&mut self, frame: &GridFrame, column: usize, row: usize, code: u8) {
        match self {
            Codes::Tiles(tiles) => tiles.set(column, row, code),
            Codes::Rows(codes) => {
                let index = frame.index(Cell::new(column, row));
                if let Some(place) = index.and_then(|index| codes.get_mut(index)) {
                    *place = code;
                }
            }
        }
    }

    /// The code at a point of the map \[m\], or off it.
    pub(super) fn at(&self, frame: &GridFrame, point: &Point2<f64>) -> u8 {
        match self {
            Codes::Tiles(tiles) => {
                let at = frame.to_cells(point);
                tiles.codes()[tiles.place_of(at.x, at.y) as usize]
            }
            Codes::Rows(codes) => codes[place_in_rows(frame, point)],
        }
    }
}

/// The place of a point in rows; that after the last cell for points off the map.
pub(super) fn place_in_rows(frame: &GridFrame, point: &Point2<f64>) -> usize {
    let cell = frame.cell_at(point).and_then(|cell| frame.index(cell));
    cell.unwrap_or(frame.cell_count())
}
