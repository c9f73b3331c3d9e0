//! CARMEN logs: one message a line, of odometry and laser scans.
//!
//! Read are `ODOM`, `FLASER`, `ROBOTLASER1`, `TRUEPOS` and the `PARAM`s that say how a laser sees;
//! everything else is counted and passed over. A log may be gzipped. Lengths are metres, angles
//! radians, stamps those of the robot (`ipc_timestamp`).
//!
//! ```
//! use loc_sim::source::carmen::{CarmenLog, Message};
//! let log = "PARAM robot_frontlaser_offset 0.2 nohost 0\n\
//!            ODOM 1.0 2.0 0.5 0.1 0 0 7.5 nohost 7.5\n\
//!            FLASER 3 1.0 2.0 90.0 1.2 2.0 0.5 1.0 2.0 0.5 7.6 nohost 7.6\n";
//! let messages: Vec<Message> = CarmenLog::parse("demo.log", log.as_bytes()).collect::<Result<_, _>>()?;
//! let Message::Laser(laser) = &messages[1] else { panic!("a scan") };
//! assert_eq!((laser.stamp, laser.scan.ranges[1], laser.scan.ranges[2]), (7.6, 2.0, f64::INFINITY));
//! # Ok::<(), loc_sim::Error>(())
//! ```

mod laser;
mod log;
mod recording;

pub use laser::CarmenLaser;
pub use log::CarmenLog;

use loc_core::{Pose2, Stamped};

/// A message of a CARMEN log.
#[derive(Debug, Clone, PartialEq)]
pub enum Message {
    /// The pose of the robot in its odometry.
    Odometry(Stamped<Pose2>),
    /// A scan of the front laser.
    Laser(CarmenLaser),
    /// The true pose of a simulated robot.
    Truth(Stamped<Pose2>),
}
