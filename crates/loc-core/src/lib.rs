#![doc = include_str!("../README.md")]

pub mod angle;
pub mod error;
pub mod file;
pub mod gaussian;
pub mod kinematics;
pub mod motion;
pub mod pose;
pub mod probability;
pub mod random;
pub mod sampling;
pub mod settings;
pub mod stats;
pub mod table;
pub mod trajectory;

pub use error::{Error, Result};
pub use gaussian::{Ellipse, Gaussian, Normal};
pub use motion::Twist2;
pub use pose::Pose2;
pub use trajectory::{Stamped, Trajectory};

/// The linear algebra library whose types this crate's interface uses.
pub use nalgebra;
