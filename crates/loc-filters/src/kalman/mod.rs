//! The Kalman filter for linear systems, in one dimension (G1) and in many (G2).
//!
//! The belief is a Gaussian. Prediction moves it by the system's equation and widens it by the
//! noise; correction pulls it towards a measurement, as strongly as the two are trusted. A step
//! without a measurement is a prediction without a correction (G5).
//!
//! ```
//! use loc_filters::{Gate, ScalarKalmanFilter};
//! // G3: a robot stands still, two sensors measure its position.
//! let mut filter = ScalarKalmanFilter::new(0.0, 20.0)?;
//! filter.correct(1.0, 9.4, 0.25, &Gate::OPEN)?;
//! filter.correct(1.0, 10.6, 1.0, &Gate::OPEN)?;
//! assert!((filter.mean() - 9.5445545).abs() < 1e-7);
//! # Ok::<(), loc_filters::Error>(())
//! ```

pub(crate) mod factor;
mod linear;
mod product;
mod scalar;
pub(crate) mod update;

pub use linear::{KalmanFilter, LinearMeasurement, LinearMotion};
pub use scalar::ScalarKalmanFilter;
