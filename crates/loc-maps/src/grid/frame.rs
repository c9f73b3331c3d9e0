//! Where the cells of a grid lie in the map: size, resolution and origin.
//!
//! The grid has a frame of its own, measured in cells: u along the columns, v along the rows,
//! (0, 0) at the lower-left **corner** of the first cell, whose centre is therefore (0.5, 0.5).
//! The origin is the pose of that corner in the map, and its yaw turns the whole grid.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_maps::grid::{Cell, GridFrame};
//! use nalgebra::Point2;
//! let frame = GridFrame::new(4, 3, 0.5, Pose2::new(10.0, 20.0, 0.0))?;
//! assert_eq!(frame.cell_at(&Point2::new(10.7, 20.1)), Some(Cell::new(1, 0)));
//! assert_eq!(frame.center(Cell::new(0, 0)), Point2::new(10.25, 20.25));
//! # Ok::<(), loc_maps::Error>(())
//! ```

use crate::Result;
use loc_core::Pose2;
use nalgebra::Point2;

/// The maximum number of cells of a grid (16384 x 16384, 0.67 km^2 at 5 cm).
pub const MAX_CELLS: usize = 1 << 28;

/// A cell of a grid, counted from the lower-left one, which is (0, 0).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Cell {
    /// Its column, along the grid's x axis.
    pub column: usize,
    /// Its row, along the grid's y axis.
    pub row: usize,
}

/// Size, resolution and origin of a grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridFrame {
    width: usize,
    height: usize,
    resolution: f64,
    origin: Pose2,
    sin: f64,
    cos: f64,
}

impl Cell {
    /// A cell from its column and its row.
    pub const fn new(column: usize, row: usize) -> Self {
        Cell { column, row }
    }
}

impl GridFrame {
    /// A frame of `width` x `height` cells with sides of `resolution` \[m\], whose lower-left
    /// corner stands at `origin` (`map_from_grid`).
    ///
    /// # Errors
    /// [`loc_core::Error`] for a grid without cells or with more than [`MAX_CELLS`], a resolution
    /// that is not a finite number > 0, and an origin that is not finite.
    pub fn new(width: usize, height: usize, resolution: f64, origin: Pose2) -> Result<Self> {
        let cells = width.saturating_mul(height);
        if cells == 0 || cells > MAX_CELLS {
            let expected = "1 to 2^28 cells";
            return Err(loc_core::Error::Length { what: "grid", expected, found: cells }.into());
        }
        loc_core::error::positive("resolution [m]", resolution)?;
        loc_core::error::finite("origin x [m]", origin.x)?;
        loc_core::error::finite("origin y [m]", origin.y)?;
        loc_core::error::finite("origin yaw [rad]", origin.theta)?;
        let (sin, cos) = origin.theta.sin_cos();
        Ok(GridFrame { width, height, resolution, origin, sin, cos })
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.width * self.height
    }

    /// Side of a cell \[m\].
    pub fn resolution(&self) -> f64 {
        self.resolution
    }

    /// Pose of the lower-left corner of cell (0, 0) in the map.
    pub fn origin(&self) -> Pose2 {
        self.origin
    }

    /// A point of the map \[m\] in the grid's frame \[cells\], inside the grid or not.
    #[inline]
    pub fn to_cells(&self, point: &Point2<f64>) -> Point2<f64> {
        let (dx, dy) = (point.x - self.origin.x, point.y - self.origin.y);
        Point2::new(
            (self.cos * dx + self.sin * dy) / self.resolution,
            (self.cos * dy - self.sin * dx) / self.resolution,
        )
    }

    /// The point of the map \[m\] at (u, v) of the grid's frame \[cells\].
    #[inline]
    pub fn to_map(&self, u: f64, v: f64) -> Point2<f64> {
        let (dx, dy) = (u * self.resolution, v * self.resolution);
        Point2::new(
            self.origin.x + self.cos * dx - self.sin * dy,
            self.origin.y + self.sin * dx + self.cos * dy,
        )
    }

    /// A vector of the map, turned into the grid's frame; its length stays.
    #[inline]
    pub fn turn_to_grid(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.cos * x + self.sin * y, self.cos * y - self.sin * x]
    }

    /// The cell that holds a point of the map \[m\]; a cell owns its lower and left edges.
    #[inline]
    pub fn cell_at(&self, point: &Point2<f64>) -> Option<Cell> {
        let Point2 { coords } = self.to_cells(point);
        let inside = coords.x >= 0.0 && coords.y >= 0.0;
        // The cast truncates and saturates, so that NaN and far points stay outside.
        let cell = Cell::new(coords.x as usize, coords.y as usize);
        (inside && self.contains(cell)).then_some(cell)
    }

    /// The centre of a cell in the map \[m\].
    pub fn center(&self, cell: Cell) -> Point2<f64> {
        self.to_map(cell.column as f64 + 0.5, cell.row as f64 + 0.5)
    }

    /// Whether the grid has this cell.
    pub fn contains(&self, cell: Cell) -> bool {
        cell.column < self.width && cell.row < self.height
    }

    /// The place of a cell in row-major order, `None` outside the grid.
    #[inline]
    pub fn index(&self, cell: Cell) -> Option<usize> {
        self.contains(cell).then(|| cell.row * self.width + cell.column)
    }

    /// The cells in row-major order, from the bottom row up.
    pub fn cells(&self) -> impl Iterator<Item = Cell> + use<> {
        let width = self.width;
        (0..self.height).flat_map(move |row| (0..width).map(move |column| Cell::new(column, row)))
    }

    /// The four corners of the grid in the map \[m\], counter-clockwise from the origin.
    pub fn corners(&self) -> [Point2<f64>; 4] {
        let (w, h) = (self.width as f64, self.height as f64);
        [self.to_map(0.0, 0.0), self.to_map(w, 0.0), self.to_map(w, h), self.to_map(0.0, h)]
    }
}
