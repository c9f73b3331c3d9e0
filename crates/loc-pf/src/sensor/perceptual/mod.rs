//! The perceptual model learned from data: what does a range finder measure where the map lets
//! expect a certain range (K2)?
//!
//! Every beam taken at a known pose is a [`RangePair`]: the range that the map lets expect there,
//! and the one that was measured. Counted over both, many pairs give the surface
//! `p(measured | expected)`: a ridge along `measured = expected`, a slope before it from people and
//! chairs that are on no map, a wall at the longest range. [`PerceptualHistogram`] keeps the counts;
//! its [`PerceptualModel`] rates scans as it stands. [`fit_beam_model`] finds the parameters of the
//! [`BeamModel`](super::BeamModel) that explain the pairs best, by maximum likelihood.
//!
//! ```
//! use loc_core::random::stream;
//! use loc_pf::sensor::BeamModelSettings;
//! use loc_pf::sensor::perceptual::{PerceptualHistogram, RangePair, fit_beam_model};
//! use rand::RngExt;
//! let mut rng = stream(1, "laser");
//! // 5 % of the beams see nothing, the others are 3 cm off.
//! let pairs: Vec<RangePair> = (0..2000).map(|_| {
//!     let expected = rng.random_range(1.0..8.0);
//!     let off = 0.05 * rng.random_range(-1.0..1.0_f64);
//!     let measured = if rng.random_bool(0.05) { f64::INFINITY } else { expected + off };
//!     RangePair { expected, measured }
//! }).collect();
//! let start = BeamModelSettings { max_range: 10.0, ..Default::default() };
//! let fit = fit_beam_model(&pairs, &start)?;
//! assert!(fit.converged && (fit.settings.z_max - 0.05).abs() < 0.02);
//! assert!((fit.settings.sigma_hit - 0.05 / 3_f64.sqrt()).abs() < 0.002);
//!
//! let mut histogram = PerceptualHistogram::new(10.0, 0.1)?;
//! pairs.iter().for_each(|&pair| histogram.add(pair));
//! let model = histogram.model();
//! assert!(model.density(5.0, 5.0) > 100.0 * model.density(5.0, 3.0));
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod fit;
mod histogram;
mod model;
mod pair;
mod statistics;

pub use fit::{FitReport, fit_beam_model};
pub use histogram::PerceptualHistogram;
pub use model::PerceptualModel;
pub use pair::{RangePair, range_pairs};
