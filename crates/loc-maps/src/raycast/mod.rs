//! Casting rays through an occupancy grid: how far is the wall in this direction?
//!
//! It is what a laser measures, used by the simulated sensor and by the beam model of a particle
//! filter thousands of times a second. The answer is exact: the distance at which the ray
//! enters the first occupied cell, for any pose on the map or off it (what lies off the map is
//! free), with the yaw of the map's origin honoured.
//!
//! [`OccupancyGrid`](crate::OccupancyGrid) casts by traversal from cell to cell (Amanatides and
//! Woo, "A fast voxel traversal algorithm", 1987): no preparation, a step for every cell.
//! [`RayCaster`] gives the same answers faster, for casting many rays through a map that stays as
//! it is: it keeps one bit a cell and tests all the cells of a ray in one row at once.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_maps::grid::{Cell, GridFrame, OccupancyGrid};
//! use loc_maps::RayCaster;
//! use loc_sensors::world::RangeWorld;
//! use nalgebra::Point2;
//! let mut grid = OccupancyGrid::filled(GridFrame::new(100, 100, 0.05, Pose2::IDENTITY)?, 0);
//! (0..100).try_for_each(|row| grid.set(Cell::new(80, row), 100))?;
//! let caster = RayCaster::new(&grid);
//! let range = caster.cast(&Point2::new(1.0, 2.5), 0.0, 10.0);
//! assert!((range.unwrap() - 3.0).abs() < 1e-12);
//! assert_eq!(range, grid.cast(&Point2::new(1.0, 2.5), 0.0, 10.0));
//! # Ok::<(), loc_maps::Error>(())
//! ```

mod caster;
mod traversal;

pub use caster::RayCaster;
pub use traversal::{GridRay, Traversal};
