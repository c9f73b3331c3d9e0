//! The three classes of a cell: free, occupied, unknown.
//!
//! A cell carries the value of the ROS occupancy message: the probability of being occupied in
//! percent, 0 to 100, or -1 where nothing is known. Methods that need a yes or no take the
//! customary thresholds of map files: at least 0.65 is occupied, at most 0.196 is free.
//!
//! ```
//! use loc_maps::grid::Occupancy;
//! assert_eq!(Occupancy::of(100), Occupancy::Occupied);
//! assert_eq!(Occupancy::of(0), Occupancy::Free);
//! assert_eq!(Occupancy::of(-1), Occupancy::Unknown);
//! ```

/// The value of a cell of which nothing is known.
pub const UNKNOWN: i8 = -1;

/// The lowest value of an occupied cell \[percent\].
pub const OCCUPIED_FROM: i8 = 65;

/// The highest value of a free cell \[percent\] (19.6, rounded down to what a cell can hold).
pub const FREE_TO: i8 = 19;

/// What is known of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Occupancy {
    /// Nothing stands there.
    Free,
    /// Something stands there.
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
