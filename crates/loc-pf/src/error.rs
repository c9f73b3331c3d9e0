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
    /// An input belongs to a time older than the history that the filter keeps.
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
        /// How far back the filter keeps its history \[s\].
        horizon: f64,
    },
    /// An initial pose that is not on the map.
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
        /// The number of threads wanted.
        threads: usize,
        /// The system's message.
        reason: String,
    },
}

/// Shorthand for results of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
