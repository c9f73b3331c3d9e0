//! The one error type of this crate.

use crate::grid::Cell;
use std::path::PathBuf;

/// What went wrong with a map.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A number, a file or a line of it is wrong.
    #[error(transparent)]
    Core(#[from] loc_core::Error),
    /// Two landmarks share a number.
    #[error("landmark {id}: expected one position, got a second one")]
    DuplicateLandmark {
        /// The number.
        id: u32,
    },
    /// A line whose ends are one point.
    #[error("line at ({x} m, {y} m): expected two different ends, got the same one twice")]
    LineWithoutLength {
        /// Position along x \[m\].
        x: f64,
        /// Position along y \[m\].
        y: f64,
    },
    /// Two places share a name.
    #[error("place `{name}`: expected one place of this name, got a second one")]
    DuplicatePlace {
        /// The name.
        name: String,
    },
    /// An edge leads to a place that the map does not have.
    #[error("edge {edge}: expected two of {places} places, got number {found}")]
    UnknownPlace {
        /// Index of the edge.
        edge: usize,
        /// Number of places.
        places: usize,
        /// The index that came.
        found: usize,
    },
    /// An edge that joins nothing new.
    #[error("edge {edge}: expected two different places not joined yet, got `{from}` and `{to}`")]
    UselessEdge {
        /// Index of the edge.
        edge: usize,
        /// Name of one place.
        from: String,
        /// Name of the other.
        to: String,
    },
    /// A TOML file that cannot be understood.
    #[error("{}:{line}: {message}", file.display())]
    Toml {
        /// The file.
        file: std::path::PathBuf,
        /// Line number, counted from 1.
        line: usize,
        /// What was expected and what came.
        message: String,
    },
    /// A grid has more or fewer values than cells.
    #[error("grid: expected {width} x {height} values, got {found}")]
    CellCount {
        /// Number of columns.
        width: usize,
        /// Number of rows.
        height: usize,
        /// The number of values that came.
        found: usize,
    },
    /// A cell's value is none of the occupancy message.
    #[error("cell ({}, {}): expected a value of -1 to 100, got {found}", cell.column, cell.row)]
    CellValue {
        /// The cell.
        cell: Cell,
        /// The value that came.
        found: i8,
    },
    /// A cell lies outside the grid.
    #[error("cell ({}, {}): expected one of {width} x {height} cells", cell.column, cell.row)]
    OutsideGrid {
        /// The cell.
        cell: Cell,
        /// Number of columns.
        width: usize,
        /// Number of rows.
        height: usize,
    },
    /// No generated world has this name.
    #[error("world: expected one of {}, got `{found}`", crate::worlds::NAMES.join(", "))]
    UnknownWorld {
        /// The name that came.
        found: String,
    },
    /// A YAML file cannot be understood.
    #[error("{}:{line}: {message}", file.display())]
    Yaml {
        /// The file.
        file: PathBuf,
        /// Line number, counted from 1; 0 where it is not known.
        line: u64,
        /// What the reader said.
        message: String,
    },
    /// A file of a map does not hold what it must.
    #[error("{}: {field}: expected {expected}, got {found}", file.display())]
    MapFile {
        /// The file, YAML or image.
        file: PathBuf,
        /// The field of it.
        field: &'static str,
        /// What belongs there.
        expected: String,
        /// What stands there.
        found: String,
    },
    /// The map has no free cells.
    #[error("map of {width} x {height} cells: expected free cells, got none")]
    NoFreeSpace {
        /// Columns of the map.
        width: usize,
        /// Rows of the map.
        height: usize,
    },
    /// A likelihood field was not made from the map that it came with.
    #[error("likelihood field: expected one with size, resolution and origin of the map")]
    OtherFrame,
    /// The system started no threads.
    #[error("{threads} threads: {reason}")]
    Threads {
        /// The number of threads wanted.
        threads: usize,
        /// The system's message.
        reason: String,
    },
}

/// Shorthand for results of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
