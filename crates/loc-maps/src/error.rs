//! The one error type of this crate.

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
}

/// Shorthand for results of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
