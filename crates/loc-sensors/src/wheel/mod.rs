//! Wheel odometry (B1): the velocity that the wheels report.
//!
//! Each wheel counts its turns; radius and track, as the robot believes them, make a velocity of
//! that. [`WheelOdometry`] simulates the chain: the true motion turns the true wheels, the
//! systematic causes of E7 ([`WheelFaults`]) come between wheel and ground, random errors follow
//! the lectures' error model. [`OdometryCalibration`] goes the other way and takes the systematic
//! part out of a recorded velocity.
//!
//! ```
//! use loc_core::{Twist2, random::stream};
//! use loc_sensors::wheel::{WheelFaults, WheelOdometry};
//! let worn_left_wheel = WheelFaults { left_radius: 0.98, ..WheelFaults::NONE };
//! let odometry = WheelOdometry::new(0.4)?.with_faults(worn_left_wheel)?;
//! let straight = Twist2::forward(1.0, 0.0);
//! let reported = odometry.measure(straight, 0.1, &mut stream(1, "odometry"));
//! assert!(reported.vx > 1.0 && reported.omega < 0.0, "the small wheel turns faster");
//! # Ok::<(), loc_core::Error>(())
//! ```

mod calibration;
mod faults;
mod odometry;

pub use calibration::OdometryCalibration;
pub use faults::WheelFaults;
pub use odometry::WheelOdometry;
