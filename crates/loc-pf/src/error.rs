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

/// So that localizers of this crate can implement [`loc_filters::Localizer`].
impl From<Error> for loc_filters::Error {
    fn from(error: Error) -> Self {
        match error {
            Error::Core(error) => error.into(),
            Error::Maps(error) => error.into(),
            Error::Filter(error) => error,
            other => loc_filters::Error::Other(Box::new(other)),
        }
    }
}

/// Shorthand for results of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
