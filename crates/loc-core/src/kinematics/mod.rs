//! What the wheels of a drive have to do with the robot's velocity, both ways (E1, E3, E4).
//!
//! Wheel speeds are rim speeds \[m/s\]: revolutions times circumference. Each drive has `twist`,
//! from its wheels to the robot's [`Twist2`](crate::Twist2); the way back; and the Jacobian of the former, which
//! takes the noise of the wheels to that of the velocity: `S_u = J S_wheels J^T`.
//!
//! ```
//! use loc_core::kinematics::Differential;
//! let drive = Differential::new(0.4)?;
//! let twist = drive.twist(0.9, 1.1);
//! assert!((twist.vx - 1.0).abs() < 1e-12 && (twist.omega - 0.5).abs() < 1e-12);
//! # Ok::<(), loc_core::Error>(())
//! ```

mod ackermann;
mod differential;
mod mecanum;

pub use ackermann::Ackermann;
pub use differential::Differential;
pub use mecanum::{Mecanum, MecanumWheels};
