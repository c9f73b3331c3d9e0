//! The codes of a map's cells, in the form that suits its size.

use super::tiles::{LONGEST_SIDE, Tiles};
use crate::grid::{Cell, GridFrame};
use nalgebra::Point2;

/// One byte a cell.
#[derive(Debug, Clone)]
pub(super) enum Codes {
    /// Of a map of ordinary size.
    Tiles(Tiles),
    /// Of a map with so long a side that single precision does not tell its cells apart (13 km at
    /// 5 cm): row by row, and after the last cell the code of what lies off the map.
    Rows(Vec<u8>),
}

impl Codes {
    /// Room for the codes of a grid, filled with that of what lies off the map.
    pub(super) fn new(frame: &GridFrame, off_map: u8) -> Self {
        if frame.width().max(frame.height()) <= LONGEST_SIDE {
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

    /// Gives a cell of the grid its code.
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
