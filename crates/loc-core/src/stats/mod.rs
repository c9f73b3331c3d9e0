//! Statistics of samples, and consistency tests of estimators (F2).
//!
//! A sample is a list of measured numbers: the errors of a run, say. [`RunningMoments`] adds them
//! one at a time and gives mean and variance; [`median`] and [`quantile`] are robust to a few
//! outliers. An estimator also reports the covariance of its error: [`nees`] normalises the error
//! by it, and [`chi_square_band`] is the interval of that figure for a consistent estimator;
//! [`consistency`] has the tests over many runs.
//!
//! ```
//! use loc_core::stats::{self, RunningMoments};
//! let errors = [0.1, 0.3, 0.2, 9.0];
//! let moments = RunningMoments::of(errors)?;
//! assert!((moments.mean().unwrap_or(0.0) - 2.4).abs() < 1e-12);
//! assert!((stats::median(&errors)? - 0.25).abs() < 1e-12);
//! // The mean NEES of a pose (3 degrees of freedom) over 50 runs lies here, 95 times of 100:
//! let band = stats::chi_square_band(3, 50, 0.95)?;
//! assert!(*band.start() > 2.3 && *band.end() < 3.8);
//! # Ok::<(), loc_core::Error>(())
//! ```

mod chi_square;
pub mod consistency;
mod sample;

pub use chi_square::{
    chi_square_band, chi_square_cdf, chi_square_interval, chi_square_quantile, mean_interval,
    wilson_interval,
};
pub use consistency::{autocorrelation, nees, whiteness_bound};
pub(crate) use sample::normalized;
pub use sample::{
    RunningMoments, correlation, covariance, covariance_matrix, median, quantile, rms,
    sample_gaussian,
};
