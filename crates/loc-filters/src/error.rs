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
    /// A map has no free cell.
    #[error("map of {width} x {height} cells: expected at least one free cell, got none")]
    NoFreeSpace {
        /// Number of columns.
        width: usize,
        /// Number of rows.
        height: usize,
    },
    /// A start without a free place within reach.
    #[error("{what}: expected a free place within reach, got none")]
    NoRoom {
        /// The start.
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
    /// Newton's method does not converge.
    #[error(
        "Newton's method from {start}: expected circles that cross, and a start beside the \
             line through their centres, got no root"
    )]
    NoRoot {
        /// Where it started \[m\].
        start: String,
    },
    /// A covariance is no longer positive, by rounding or by extreme numbers. The filter must be
    /// restarted.
    #[error("{what}: lost its positivity at step {step}, got {found}")]
    LostPositivity {
        /// The part of the covariance.
        what: &'static str,
        /// The motion or correction that it happened at, counted from 1.
        step: u64,
        /// Its elements.
        found: String,
    },
    /// Submaps were requested together with invariant Jacobians, whose corrections turn the whole map.
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
        /// The horizon \[s\].
        horizon: f64,
    },
}

/// Shorthand for results of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
