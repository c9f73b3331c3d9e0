//! The one error type of this crate.

use std::path::PathBuf;

/// An error: what was expected, what was found instead, and where.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An error of files, numbers or poses.
    #[error(transparent)]
    Core(#[from] loc_core::Error),
    /// An error of a map.
    #[error(transparent)]
    Map(#[from] loc_maps::Error),
    /// An error of a filter.
    #[error(transparent)]
    Filter(#[from] loc_filters::Error),
    /// An error of a particle filter.
    #[error(transparent)]
    ParticleFilter(#[from] loc_pf::Error),
    /// What a bag of ROS reports.
    #[error(transparent)]
    Ros(#[from] loc_ros::Error),
    /// A recording whose parts do not fit together.
    #[error("{}: expected {expected}, got {found}", path.display())]
    Recording {
        /// The file or folder.
        path: PathBuf,
        /// What was expected.
        expected: String,
        /// What was found instead.
        found: String,
    },
    /// An invalid scenario or configuration.
    #[error("{file}: {message}")]
    Config {
        /// The file, or the name of the built-in scenario.
        file: String,
        /// Line, field, what was expected and what came.
        message: String,
    },
    /// An unknown name.
    #[error("{what}: expected one of {expected}, got `{found}`")]
    UnknownName {
        /// The kind of the name.
        what: &'static str,
        /// The known names.
        expected: String,
        /// The unknown name.
        found: String,
    },
    /// A method that cannot run on a source.
    #[error("method {method}: expected {expected}, which {source_name} has not")]
    Unsuitable {
        /// The method.
        method: String,
        /// What it needs.
        expected: &'static str,
        /// The source.
        source_name: String,
    },
    /// The folder of a study holds runs of another one.
    #[error(
        "{}: holds the runs of another study ({difference}); go on with the options it was begun \
         with, name another folder with --out, or delete the file to begin anew",
        path.display()
    )]
    OtherStudy {
        /// The journal.
        path: PathBuf,
        /// What the two studies differ in.
        difference: String,
    },
    /// The folder of a study is in use.
    #[error("{}: another study is writing there; wait for it, or name another folder with --out",
        path.display())]
    Busy {
        /// The journal.
        path: PathBuf,
    },
    /// A run without a single true pose.
    #[error("{source_name}: expected true poses to judge by, got none")]
    NoTruth {
        /// The source.
        source_name: String,
    },
    /// No two stamps of two trajectories are close enough to be paired.
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
        /// Number of pairs of poses.
        pairs: usize,
    },
}

/// Shorthand for results of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
