//! The error type of this crate.

use std::path::PathBuf;

/// What went wrong, what was expected, what came instead, and where.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// What `loc-core` reports: files, numbers, poses.
    #[error(transparent)]
    Core(#[from] loc_core::Error),
    /// A bag that is not what it claims, or has not what is needed.
    #[error("{}: expected {expected}, got {found}", path.display())]
    Recording {
        /// The file or folder.
        path: PathBuf,
        /// What was expected.
        expected: String,
        /// What came instead.
        found: String,
    },
    /// A message whose bytes are not what its type says.
    #[error("{what}: expected {expected}, got {found}")]
    Malformed {
        /// The field.
        what: String,
        /// What was expected.
        expected: String,
        /// What came instead.
        found: String,
    },
    /// A transform between two frames that nothing gives.
    #[error("no transform {target} <- {source_frame} at {stamp} s: {reason}")]
    NoTransform {
        /// The frame to be transformed into.
        target: String,
        /// The frame to be transformed from.
        source_frame: String,
        /// The time \[s\].
        stamp: f64,
        /// Which frames or times are known.
        reason: String,
    },
    /// A parameter file that cannot be understood.
    #[error("{file}: {message}")]
    Parameters {
        /// The file.
        file: String,
        /// Line, key, what was expected and what came.
        message: String,
    },
}

/// Shorthand for results of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
