//! Building an occupancy grid from scans whose poses are known (C1).
//!
//! Every beam says two things: nothing stands along it, something stands at its end. A
//! [`GridMapper`] adds this evidence up in each cell as log-odds (Moravec and Elfes, 1985;
//! Probabilistic Robotics, 9.2) and turns it into a grid when asked.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_maps::grid::Occupancy;
//! use loc_maps::mapping::{GridMapper, InverseSensorModel};
//! use loc_sensors::laser::{LaserScan, LaserScanner, LaserSpec};
//! use loc_sensors::world::Room;
//! # use nalgebra::Point2;
//!
//! let room = Room::new([-2.0, -1.5], [2.0, 1.5])?;
//! let scanner = LaserScanner::new(LaserSpec::hokuyo_ust_10lx())?;
//! let mut rng = loc_core::random::stream(1, "laser");
//! let scan = scanner.scan(&room, Pose2::IDENTITY, &mut rng);
//! let grid = GridMapper::map(&[(Pose2::IDENTITY, scan)], 0.05, InverseSensorModel::default())?;
//! assert_eq!(grid.occupancy_at(&Point2::new(1.0, 0.0)), Occupancy::Free);
//! # Ok::<(), loc_maps::Error>(())
//! ```

mod mapper;
mod model;

pub use mapper::GridMapper;
pub use model::InverseSensorModel;
