//! How a robot's pose follows from its velocity, and how sure of it one may be (E2, E6, E7).
//!
//! A drive reports a velocity, a [`Twist2`]. [`Integration`] turns it into the pose after one time
//! step, by one of three rules and with their Jacobians; [`VelocityNoise`] says how far the
//! reported velocity may be off; [`dead_reckon`] puts both together and carries mean and
//! covariance one step on. [`OdometryMotion`] is the other common description of a step: turn,
//! drive, turn. [`DrivenPath`] and [`PathNoise`] speak of poses of an odometry, and of the way
//! between them.
//!
//! ```
//! use loc_core::motion::Integration;
//! use loc_core::{Pose2, Twist2};
//! let quarter_turn = Twist2::forward(1.0, std::f64::consts::FRAC_PI_2);
//! let end = Integration::ExactArc.step(Pose2::IDENTITY, quarter_turn, 1.0);
//! assert!((end.x - 2.0 / std::f64::consts::PI).abs() < 1e-12 && (end.x - end.y).abs() < 1e-12);
//! ```

mod odometry;
mod velocity;

pub use odometry::{DrivenPath, LinearizedStep, OdometryMotion, OdometryNoise, PathNoise};
pub use velocity::{Chord, Integration, StepJacobians, Twist2, VelocityNoise, dead_reckon};
