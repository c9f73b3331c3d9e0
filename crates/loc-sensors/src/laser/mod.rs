//! A laser scanner (B8): a turning mirror deflects a beam in a plane; the time until the light
//! returns gives a distance for each of many directions.
//!
//! A [`LaserScan`] is what it reports of one turn, with the meaning of the ROS message.
//! [`LaserSpec`] is its data sheet with its [`LaserNoise`], [`LaserScanner`] simulates it, with
//! what goes wrong ([`LaserFaults`]): beams that do not return, glass that lets them pass, mirrors
//! that turn them, and the robot's own motion during the sweep.
//!
//! ```
//! use loc_core::{Pose2, random::stream};
//! use loc_sensors::laser::{LaserScanner, LaserSpec};
//! use loc_sensors::world::Room;
//! let scanner = LaserScanner::new(LaserSpec::hokuyo_ust_10lx())?;
//! let room = Room::new([-3.0, -2.0], [3.0, 2.0])?;
//! let scan = scanner.scan(&room, Pose2::IDENTITY, &mut stream(1, "laser"));
//! let ahead = scan.beams().nth(540).unwrap();
//! assert!(ahead.angle.abs() < 1e-9 && (ahead.range - 3.0).abs() < 0.15);
//! # Ok::<(), loc_core::Error>(())
//! ```

mod scan;
mod simulated;
mod spec;

pub use scan::{Beam, LaserScan};
pub use simulated::LaserScanner;
pub use spec::{LaserFaults, LaserNoise, LaserSpec};
