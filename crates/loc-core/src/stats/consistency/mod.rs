//! Whether an estimator's errors are what it claims them to be.
//!
//! A filter that reports a covariance makes a promise about its errors, which three tests hold it
//! to (Bar-Shalom, Li and Kirubarajan 2001, section 5.4):
//!
//! * **NEES**: the errors of the state, each normalised by the covariance that was claimed for it,
//!   are chi-square distributed. The truth must be known, so this is a test for simulations, best
//!   over many runs: [`NeesEnsemble`].
//! * **NIS**: so are the innovations, measurement by measurement, and these need no truth:
//!   [`ChiSquareTally`].
//! * **Whiteness**: what was expected wrongly once says nothing about the next time, so innovations
//!   are not correlated with those before: [`Whiteness`].
//!
//! ```
//! use loc_core::stats::consistency::NeesEnsemble;
//! // Two runs of three steps; each error squared has 3 degrees of freedom.
//! let mut ensemble = NeesEnsemble::new(0.95)?;
//! ensemble.push_run([(3, 2.0), (3, 3.5), (3, 2.5)].map(Some))?;
//! ensemble.push_run([(3, 4.0), (3, 3.1), (3, 30.0)].map(Some))?;
//! // The mean of the third step, 16.25, is more than chance explains.
//! assert_eq!(ensemble.share_in_band(), Some(2.0 / 3.0));
//! # Ok::<(), loc_core::Error>(())
//! ```

mod ensemble;
mod single;
mod tally;
mod whiteness;

pub use ensemble::{NeesEnsemble, NeesStep};
pub use single::{autocorrelation, nees, whiteness_bound};
pub use tally::ChiSquareTally;
pub use whiteness::Whiteness;
