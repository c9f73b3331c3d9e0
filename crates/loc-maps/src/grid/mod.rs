//! The occupancy grid (C1): a map of cells, each with its probability of being occupied.
//!
//! Mapping produces it, and most localizers use it. Cells hold the values of the ROS occupancy
//! message: 0 (certainly free) to 100 (certainly occupied), -1 unknown, row by row from the bottom.
//! Where the grid lies in the map, yaw included, is its [`GridFrame`].
//!
//! ```
//! use loc_core::Pose2;
//! use loc_maps::grid::{Cell, GridFrame, Occupancy, OccupancyGrid};
//! use nalgebra::Point2;
//! let frame = GridFrame::new(20, 10, 0.1, Pose2::new(-1.0, 0.0, 0.0))?;
//! let mut grid = OccupancyGrid::filled(frame, 0);
//! grid.set(Cell::new(3, 2), 100)?;
//! assert_eq!(grid.occupancy_at(&Point2::new(-0.65, 0.25)), Occupancy::Occupied);
//! assert_eq!(grid.occupancy_at(&Point2::new(5.0, 5.0)), Occupancy::Unknown);
//! # Ok::<(), loc_maps::Error>(())
//! ```
//!
//! The classes of a cell ([`Occupancy`]) follow from the customary thresholds of map files: at
//! least 0.65 is occupied, at most 0.196 is free.
//!
//! ```
//! use loc_maps::grid::Occupancy;
//! assert_eq!(Occupancy::of(100), Occupancy::Occupied);
//! assert_eq!(Occupancy::of(0), Occupancy::Free);
//! assert_eq!(Occupancy::of(-1), Occupancy::Unknown);
//! ```

mod frame;
#[cfg(feature = "map-server")]
pub mod io;

pub use frame::{Cell, GridFrame, MAX_CELLS};

use crate::{Error, Result};
use loc_core::Pose2;
use nalgebra::Point2;

/// An occupancy grid with its place in the map.
#[derive(Debug, Clone, PartialEq)]
pub struct OccupancyGrid {
    frame: GridFrame,
    cells: Vec<i8>,
}

impl OccupancyGrid {
    /// A grid from its values in row-major order, bottom row first.
    ///
    /// # Errors
    /// [`Error::CellCount`] unless there is one value for each cell, and [`Error::CellValue`] for
    /// values outside -1 to 100.
    pub fn new(frame: GridFrame, cells: Vec<i8>) -> Result<Self> {
        if cells.len() != frame.cell_count() {
            let (width, height) = (frame.width(), frame.height());
            return Err(Error::CellCount { width, height, found: cells.len() });
        }
        match cells.iter().position(|&value| !is_valid(value)) {
            Some(k) => {
                let cell = Cell::new(k % frame.width(), k / frame.width());
                Err(Error::CellValue { cell, found: cells[k] })
            }
            None => Ok(OccupancyGrid { frame, cells }),
        }
    }

    /// A grid from values that are known to be valid, one for each cell.
    pub(crate) fn from_valid(frame: GridFrame, cells: Vec<i8>) -> Self {
        debug_assert!(cells.len() == frame.cell_count() && cells.iter().all(|&v| is_valid(v)));
        OccupancyGrid { frame, cells }
    }

    /// A grid whose cells all have one value; anything outside 0 to 100 becomes -1.
    pub fn filled(frame: GridFrame, value: i8) -> Self {
        let value = if is_valid(value) { value } else { UNKNOWN };
        OccupancyGrid { frame, cells: vec![value; frame.cell_count()] }
    }

    /// Size, resolution and origin.
    pub fn frame(&self) -> &GridFrame {
        &self.frame
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.frame.width()
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.frame.height()
    }

    /// Side of a cell \[m\].
    pub fn resolution(&self) -> f64 {
        self.frame.resolution()
    }

    /// Pose of the lower-left corner of cell (0, 0) in the map.
    pub fn origin(&self) -> Pose2 {
        self.frame.origin()
    }

    /// All values in row-major order, bottom row first.
    pub fn values(&self) -> &[i8] {
        &self.cells
    }

    /// The values of one row from left to right; empty above the grid.
    pub fn row(&self, row: usize) -> &[i8] {
        self.cells.chunks_exact(self.width()).nth(row).unwrap_or(&[])
    }

    /// The cells with their values, row by row from the bottom.
    pub fn iter(&self) -> impl Iterator<Item = (Cell, i8)> + '_ {
        self.frame.cells().zip(self.cells.iter().copied())
    }

    /// The centres \[m\] of the cells of one class, row by row from the bottom.
    pub fn centers_of(&self, class: Occupancy) -> impl Iterator<Item = Point2<f64>> + '_ {
        let of_class = self.iter().filter(move |&(_, value)| Occupancy::of(value) == class);
        of_class.map(|(cell, _)| self.frame.center(cell))
    }

    /// The value of a cell, `None` outside the grid.
    #[inline]
    pub fn value(&self, cell: Cell) -> Option<i8> {
        self.frame.index(cell).and_then(|index| self.cells.get(index)).copied()
    }

    /// The value at a point of the map \[m\], `None` outside the grid.
    pub fn value_at(&self, point: &Point2<f64>) -> Option<i8> {
        self.value(self.frame.cell_at(point)?)
    }

    /// The class of a cell; outside the grid all is unknown.
    pub fn occupancy(&self, cell: Cell) -> Occupancy {
        self.value(cell).map_or(Occupancy::Unknown, Occupancy::of)
    }

    /// The class of the cell at a point of the map \[m\]; outside the grid all is unknown.
    pub fn occupancy_at(&self, point: &Point2<f64>) -> Occupancy {
        self.value_at(point).map_or(Occupancy::Unknown, Occupancy::of)
    }

    /// Sets the value of a cell.
    ///
    /// # Errors
    /// [`Error::OutsideGrid`] for a cell that the grid does not have, and [`Error::CellValue`]
    /// for values outside -1 to 100.
    pub fn set(&mut self, cell: Cell, value: i8) -> Result<()> {
        let (width, height) = (self.width(), self.height());
        let index = self.frame.index(cell);
        let place = index.and_then(|index| self.cells.get_mut(index));
        let place = place.ok_or(Error::OutsideGrid { cell, width, height })?;
        if !is_valid(value) {
            return Err(Error::CellValue { cell, found: value });
        }
        *place = value;
        Ok(())
    }

    /// How many cells are free, occupied and unknown.
    pub fn counts(&self) -> Counts {
        let mut counts = Counts::default();
        for &value in &self.cells {
            match Occupancy::of(value) {
                Occupancy::Free => counts.free += 1,
                Occupancy::Occupied => counts.occupied += 1,
                Occupancy::Unknown => counts.unknown += 1,
            }
        }
        counts
    }
}

fn is_valid(value: i8) -> bool {
    (UNKNOWN..=100).contains(&value)
}

/// The value of an unknown cell.
pub const UNKNOWN: i8 = -1;

/// The lowest value of an occupied cell \[percent\].
pub const OCCUPIED_FROM: i8 = 65;

/// The highest value of a free cell \[percent\] (19.6, rounded down to what a cell can hold).
pub const FREE_TO: i8 = 19;

/// The class of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Occupancy {
    /// No obstacle.
    Free,
    /// An obstacle.
    Occupied,
    /// Not observed, or undecided.
    Unknown,
}

/// How many cells a grid has of each class.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Free cells.
    pub free: usize,
    /// Occupied cells.
    pub occupied: usize,
    /// Unknown cells.
    pub unknown: usize,
}

impl Occupancy {
    /// The class of a cell's value; everything outside 0 to 100 is unknown.
    #[inline]
    pub fn of(value: i8) -> Self {
        match value {
            OCCUPIED_FROM..=100 => Occupancy::Occupied,
            0..=FREE_TO => Occupancy::Free,
            _ => Occupancy::Unknown,
        }
    }

    /// The value that stands for this class: 0, 100 or -1.
    pub fn value(self) -> i8 {
        match self {
            Occupancy::Free => 0,
            Occupancy::Occupied => 100,
            Occupancy::Unknown => UNKNOWN,
        }
    }
}
