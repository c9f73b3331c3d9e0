#![doc = include_str!("../README.md")]

pub mod association;
pub mod dead_reckoning;
pub mod delayed;
mod error;
pub mod extended;
pub mod fusion;
pub mod histogram;
pub mod innovation;
pub mod kalman;
pub mod landmark;
pub mod lateration;
pub mod line_matching;
pub mod localizer;
pub mod nonlinear;
pub mod slam;
pub mod smoother;
pub mod unscented;

pub use error::{Error, Result};
pub use extended::{ExtendedKalmanFilter, MeasurementModel, MotionModel};
pub use innovation::{Gate, Innovation};
pub use kalman::{KalmanFilter, ScalarKalmanFilter};
pub use localizer::Localizer;
pub use nonlinear::NonlinearFilter;
pub use unscented::UnscentedKalmanFilter;
