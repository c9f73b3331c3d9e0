#![doc = include_str!("../README.md")]
//!
//! | module | holds |
//! |---|---|
//! | [`robot`] | what belongs to the robot, used by every method |
//! | [`kalman`] | the linear Kalman filter in one and in n dimensions |
//! | [`extended`], [`unscented`] | the extended and the unscented Kalman filter on a user's models |
//! | [`nonlinear`] | the common trait of nonlinear filters |
//! | [`innovation`] | residual, NIS and chi-square gate of a measurement |
//! | [`association`] | data association: nearest neighbour, maximum likelihood, joint compatibility |
//! | [`delayed`] | late and out-of-order inputs |
//! | [`divergence`] | filters that notice that they have gone wrong |
//! | [`smoother`] | Rauch-Tung-Striebel smoothing of any of these filters |
//! | [`landmark`] | localization with landmarks of known positions |
//! | [`lateration`] | positions from ranges, once or over a sliding window |
//! | [`line_matching`] | localization with the walls of a line map |
//! | [`fusion`] | wheels, inertial unit, compass, satellites and landmarks in one filter |
//! | [`histogram`] | Markov localization: states, line, topological map, grid of poses |
//! | [`slam`] | SLAM with Kalman filters: linear and EKF |

pub mod association;
pub mod dead_reckoning;
pub mod delayed;
pub mod divergence;
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
pub mod robot;
pub mod slam;
pub mod smoother;
pub mod unscented;

pub use error::{Error, Result};
pub use extended::{ExtendedKalmanFilter, MeasurementModel, MotionModel};
pub use innovation::{Gate, Innovation};
pub use kalman::{KalmanFilter, ScalarKalmanFilter};
pub use localizer::Localizer;
pub use nonlinear::NonlinearFilter;
pub use robot::RobotSettings;
pub use unscented::UnscentedKalmanFilter;
