//! How a robot's pose follows from its velocity, and how uncertain it becomes (E2, E6, E7).
//!
//! A drive reports a velocity, a [`Twist2`]. [`Integration`] turns it into the pose after one time
//! step, by one of three rules and with their Jacobians; [`VelocityNoise`] is the error model of
//! the reported velocity; [`dead_reckon`] combines both and propagates mean and covariance over one
//! step. [`OdometryMotion`] is the other common description of a step: rotation, translation,
//! rotation. [`DrivenPath`] and [`PathNoise`] work on the poses that odometry reports and on the
//! path between them.
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
