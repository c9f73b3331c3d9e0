//! The one error type of this crate.

use std::path::PathBuf;

/// What went wrong, what was expected, what came instead, and where.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A number lies outside what is allowed (NaN and infinity included).
    #[error("{what}: expected {expected}, got {found}")]
    OutOfRange {
        /// The quantity, with its unit where it has one.
        what: &'static str,
        /// The values that are allowed.
        expected: &'static str,
        /// The value found.
        found: f64,
    },
    /// A covariance is not symmetric positive (semi-)definite, or not finite.
    #[error("{what}: expected a {expected} matrix, got {found}")]
    NotACovariance {
        /// The matrix.
        what: &'static str,
        /// `symmetric positive definite`, or `.. semi-definite`.
        expected: &'static str,
        /// The matrix found, printed in one line.
        found: String,
    },
    /// A collection has the wrong number of elements.
    #[error("{what}: expected {expected}, got {found} elements")]
    Length {
        /// The collection.
        what: &'static str,
        /// The lengths that are allowed.
        expected: &'static str,
        /// The length found.
        found: usize,
    },
    /// A motion that the drive cannot make (a car that slides sideways).
    #[error("{drive}: cannot {motion}")]
    ImpossibleMotion {
        /// The kind of drive.
        drive: &'static str,
        /// The requested motion.
        motion: String,
    },
    /// Time runs backwards where it must not.
    #[error("{what}: time runs backwards, from {before} s to {after} s")]
    TimeBackwards {
        /// The sequence.
        what: String,
        /// The stamp before \[s\].
        before: f64,
        /// The stamp that follows it \[s\].
        after: f64,
    },
    /// Conditioning on an event of probability 0.
    #[error("{what}: the evidence has probability 0, so nothing follows from it")]
    ImpossibleEvidence {
        /// What was to be concluded.
        what: &'static str,
    },
    /// A file or folder cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A text file does not hold what it must.
    #[error("{}:{line}: {field}: expected {expected}, got {found}", file.display())]
    Parse {
        /// The file.
        file: PathBuf,
        /// Line number, counted from 1.
        line: usize,
        /// The column's name.
        field: String,
        /// The expected content of the field.
        expected: String,
        /// The text found.
        found: String,
    },
    /// A file holds no data at all.
    #[error("{}: {what}: the file holds none", file.display())]
    Empty {
        /// The file.
        file: PathBuf,
        /// The expected content.
        what: &'static str,
    },
}

/// Shorthand for results of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// Attaches a path to an [`std::io::Error`]: `map_err(Error::io(path))`.
    pub fn io(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Error {
        let path = path.into();
        move |source| Error::Io { path, source }
    }
}

/// Checks that `value` is finite.
///
/// # Errors
/// [`Error::OutOfRange`] for NaN and infinity.
pub fn finite(what: &'static str, value: f64) -> Result<f64> {
    in_range(what, "a finite number", value, f64::is_finite)
}

/// Checks that `value` is finite and at least 0.
///
/// # Errors
/// [`Error::OutOfRange`] otherwise.
pub fn non_negative(what: &'static str, value: f64) -> Result<f64> {
    in_range(what, "a finite number >= 0", value, |v| v.is_finite() && v >= 0.0)
}

/// Checks that `value` is finite and above 0.
///
/// # Errors
/// [`Error::OutOfRange`] otherwise.
pub fn positive(what: &'static str, value: f64) -> Result<f64> {
    in_range(what, "a finite number > 0", value, |v| v.is_finite() && v > 0.0)
}

/// Checks that `value` is a probability in \[0, 1\].
///
/// # Errors
/// [`Error::OutOfRange`] otherwise.
pub fn probability(what: &'static str, value: f64) -> Result<f64> {
    in_range(what, "a probability in [0, 1]", value, |v| (0.0..=1.0).contains(&v))
}

/// Checks `found` by a predicate; `expected` says in words what it allows.
///
/// # Errors
/// [`Error::OutOfRange`] where the predicate does not hold.
pub fn in_range(
    what: &'static str,
    expected: &'static str,
    found: f64,
    allowed: impl Fn(f64) -> bool,
) -> Result<f64> {
    if allowed(found) { Ok(found) } else { Err(Error::OutOfRange { what, expected, found }) }
}
