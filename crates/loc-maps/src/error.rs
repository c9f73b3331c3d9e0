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
}

/// Shorthand for results of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
