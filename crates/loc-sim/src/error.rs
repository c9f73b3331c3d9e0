//! The one error type of this crate.

/// What went wrong, what was expected, what came instead, and where.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Anything that the crates below report: files, numbers, poses.
    #[error(transparent)]
    Core(#[from] loc_core::Error),
    /// No two stamps of two trajectories lie close enough to belong together.
    #[error(
        "{estimate} (from {estimate_start} s to {estimate_end} s) and {reference} (from \
         {reference_start} s to {reference_end} s): expected stamps within {max_dt} s of each \
         other, got none"
    )]
    NoCommonStamps {
        /// Name of the estimate, its file where it came from one.
        estimate: String,
        /// First stamp of the estimate \[s\].
        estimate_start: f64,
        /// Last stamp of the estimate \[s\].
        estimate_end: f64,
        /// Name of the reference, its file where it came from one.
        reference: String,
        /// First stamp of the reference \[s\].
        reference_start: f64,
        /// Last stamp of the reference \[s\].
        reference_end: f64,
        /// The largest difference in time that was allowed \[s\].
        max_dt: f64,
    },
    /// The positions do not determine an alignment.
    #[error(
        "alignment se2: expected positions that determine a rotation about z, got {pairs} pair(s) \
         that fit every rotation equally well"
    )]
    UndeterminedAlignment {
        /// Number of pairs of poses that there were.
        pairs: usize,
    },
}

/// Shorthand for results of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
