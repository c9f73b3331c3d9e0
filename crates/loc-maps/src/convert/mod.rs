//! From one kind of map to another, where that has a meaning.
//!
//! An architect's drawing becomes a grid for a particle filter, a grid that a robot has built
//! becomes lines to match against, and everything becomes points for scan matching:
//!
//! | from | to | by |
//! |---|---|---|
//! | lines, points | grid | [`LineMap::to_grid`], [`LineMap::rasterize`], [`PointMap::to_grid`], [`PointMap::rasterize`] |
//! | grid | points | [`PointMap::from_grid`] |
//! | grid | lines | [`LineMap::from_grid`], [`LineMap::outline`] |
//! | lines | points | [`PointMap::from_lines`] |
//! | scans with poses | points | [`PointMap::from_scans`] |
//! | grid | places | [`TopologicalMap::from_grid`](crate::TopologicalMap::from_grid) |
//! | all | SVG picture | [`MapPicture`](crate::MapPicture) |
//!
//! ```
//! use loc_maps::convert::Surface;
//! use loc_maps::{LineMap, PointMap};
//! let room = LineMap::parse_csv("room.csv", "0,0,4,0\n4,0,4,3\n4,3,0,3\n0,3,0,0\n")?;
//! let grid = room.to_grid(0.05, 0.5)?;
//! let points = PointMap::from_grid(&grid, Surface::Boundary)?;
//! assert_eq!(points.len(), grid.counts().occupied);
//!
//! let again = LineMap::from_grid(&grid, &Default::default())?;
//! assert_eq!(again.len(), 4);
//! # Ok::<(), loc_maps::Error>(())
//! ```
//!
//! [`LineMap::to_grid`]: crate::LineMap::to_grid
//! [`LineMap::rasterize`]: crate::LineMap::rasterize
//! [`LineMap::from_grid`]: crate::LineMap::from_grid
//! [`LineMap::outline`]: crate::LineMap::outline
//! [`PointMap::to_grid`]: crate::PointMap::to_grid
//! [`PointMap::rasterize`]: crate::PointMap::rasterize
//! [`PointMap::from_grid`]: crate::PointMap::from_grid
//! [`PointMap::from_lines`]: crate::PointMap::from_lines
//! [`PointMap::from_scans`]: crate::PointMap::from_scans

mod grow;
mod outline;
mod points;
mod rasterize;
mod vectorize;

pub use points::Surface;
pub use vectorize::VectorizeSettings;
