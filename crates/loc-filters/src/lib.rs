#![doc = include_str!("../README.md")]

pub mod delayed;
mod error;
pub mod extended;
pub mod innovation;
pub mod kalman;
pub mod landmark;
pub mod line_matching;

pub use error::{Error, Result};
pub use extended::{ExtendedKalmanFilter, MeasurementModel, MotionModel};
pub use innovation::{Gate, Innovation};
pub use kalman::{KalmanFilter, ScalarKalmanFilter};
