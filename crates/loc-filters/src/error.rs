//! The one error type of this crate.

/// What went wrong in a filter.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A number, a distribution or a setting is wrong.
    #[error(transparent)]
    Core(#[from] loc_core::Error),
    /// A map is wrong.
    #[error(transparent)]
    Map(#[from] loc_maps::Error),
    /// A map has no place for a robot.
    #[error("map of {width} x {height} cells: expected at least one free cell, got none")]
    NoFreeSpace {
        /// Number of columns.
        width: usize,
        /// Number of rows.
        height: usize,
    },
    /// A robot is said to be where it cannot be.
    #[error("{what}: expected a free place within reach, got none")]
    NoRoom {
        /// What was said.
        what: &'static str,
    },
    /// A measurement holds NaN or infinity.
    #[error("{what}: expected finite numbers, got {found}")]
    NotFinite {
        /// The vector.
        what: &'static str,
        /// Its elements.
        found: String,
    },
    /// There are more unknowns than distances.
    #[error(
        "lateration: expected at least {expected} distances, one for each unknown, got {found}"
    )]
    TooFewRanges {
        /// The number of unknowns.
        expected: usize,
        /// The number of distances.
        found: usize,
    },
    /// The landmarks leave open where the robot is, whatever the distances are.
    #[error("lateration: expected {expected}, got {found}")]
    Undetermined {
        /// What would determine the place.
        expected: &'static str,
        /// What came instead.
        found: String,
    },
    /// Newton's method does not come to rest.
    #[error(
        "Newton's method from {start}: expected circles that cross, and a start beside the \
             line through their centres, got no root"
    )]
    NoRoot {
        /// Where it started \[m\].
        start: String,
    },
    /// Rounding, or numbers beyond all reason, have made a covariance negative. The filter must be
    /// started anew.
    #[error("{what}: lost its positivity at step {step}, got {found}")]
    LostPositivity {
        /// The part of the covariance.
        what: &'static str,
        /// The motion or correction that it happened at, counted from 1.
        step: u64,
        /// Its elements.
        found: String,
    },
    /// A part of the map is to stand for all of it in a filter that turns the whole map.
    #[error(
        "SLAM on submaps: expected the jacobians `current` or `first`, got `invariant`, by which \
         a correction of the heading turns the whole map"
    )]
    SubmapTurns,
    /// What a localizer of another crate reports.
    #[error(transparent)]
    Other(Box<dyn std::error::Error + Send + Sync>),
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
}

/// Shorthand for results of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
