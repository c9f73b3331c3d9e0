//! The one error type of this crate.

/// What went wrong, what was expected, what came instead, and where.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// From the foundation and the sensors: numbers out of range, wrong lengths, files.
    #[error(transparent)]
    Core(#[from] loc_core::Error),
    /// From the maps.
    #[error(transparent)]
    Maps(#[from] loc_maps::Error),
    /// From the filters that particles are made of.
    #[error(transparent)]
    Filter(#[from] loc_filters::Error),
    /// The map has no place where a robot could be.
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
    /// An input belongs to a time so far back that the filter has forgotten it.
    #[error(
        "{what} at {stamp} s: expected at most {horizon} s before {newest} s, the newest input"
    )]
    TooLate {
        /// The input.
        what: &'static str,
        /// Its time \[s\].
        stamp: f64,
        /// Time of the newest input \[s\].
        newest: f64,
        /// How far back the filter remembers \[s\].
        horizon: f64,
    },
    /// A start pose that is not on the map.
    #[error("start pose: expected one on the map, got x = {x} m, y = {y} m")]
    OffMap {
        /// Where it is \[m\].
        x: f64,
        /// Where it is \[m\].
        y: f64,
    },
    /// The system started no threads.
    #[error("{threads} threads: {reason}")]
    Threads {
        /// How many were asked for.
        threads: usize,
        /// What the system said.
        reason: String,
    },
}

/// Shorthand for results of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
