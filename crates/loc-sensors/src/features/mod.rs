//! Lines in a laser scan: walls, as a robot recognises them.
//!
//! Indoors most beams end on straight walls. Each wall is one line `x cos(alpha) + y sin(alpha) =
//! r`: alpha is the direction of its perpendicular, r its distance from the scanner. Two numbers
//! that hundreds of beams agree on are known far better than any single range, and
//! [`Line::covariance`] says how well. [`LineExtractor`] finds them by split and merge, and fits
//! each by weighted total least squares.
//!
//! ```
//! use loc_core::{Pose2, random::stream};
//! use loc_sensors::features::LineExtractor;
//! use loc_sensors::laser::{LaserScanner, LaserSpec};
//! use loc_sensors::world::Room;
//! let spec = LaserSpec::sick_lms100();
//! let room = Room::new([-3.0, -2.0], [3.0, 2.0])?;
//! let scan = LaserScanner::new(spec)?.scan(&room, Pose2::IDENTITY, &mut stream(1, "laser"));
//! let walls = LineExtractor::new(spec.noise).extract(&scan)?;
//! assert_eq!(walls.len(), 3, "the wall behind lies in the blind angle");
//! assert!((walls[1].r - 3.0).abs() < 0.01 && walls[1].alpha.abs() < 0.01);
//! # Ok::<(), loc_core::Error>(())
//! ```

mod extract;
mod line;

pub use extract::LineExtractor;
pub use line::Line;
