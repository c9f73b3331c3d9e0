//! A grid with walls that stand up: what a camera sees of it.
//!
//! A floor plan has no heights. Here every connected piece of occupied cells becomes a body: one
//! that is long is a wall of the building, full height; a small one is furniture, lower, so that
//! one looks over it. Walls are shaded by the way that they face, as under a lamp, and bear a faint
//! pattern of panels; furniture has colours. All of it follows from the map alone.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_maps::ExtrudedGrid;
//! use loc_maps::grid::{Cell, GridFrame, OccupancyGrid};
//! use loc_sensors::world::WallWorld;
//! let mut grid = OccupancyGrid::filled(GridFrame::new(100, 60, 0.1, Pose2::IDENTITY)?, 0);
//! (0..60).try_for_each(|row| grid.set(Cell::new(90, row), 100))?;
//! grid.set(Cell::new(50, 30), 100)?;
//! let rooms = ExtrudedGrid::new(grid, 2.5)?;
//! let mut heights = Vec::new();
//! rooms.visit_walls(&[1.0, 3.05].into(), 0.0, 20.0, &mut |wall| {
//!     heights.push(wall.height);
//!     true
//! });
//! assert!(heights.len() == 2 && heights[0] < 1.5, "a stool before a wall");
//! assert_eq!(heights[1], 2.5);
//! # Ok::<(), loc_maps::Error>(())
//! ```

mod bodies;
mod paint;

use crate::Result;
use crate::grid::{Occupancy, OccupancyGrid};
use crate::raycast::{GridRay, Traversal};
use bodies::Bodies;
use loc_core::error::positive;
use loc_sensors::world::{Rgb, WallHit, WallWorld};
use nalgebra::Point2;

/// An occupancy grid as a world of walls and furniture.
#[derive(Debug, Clone)]
pub struct ExtrudedGrid {
    grid: OccupancyGrid,
    height: f64,
    bodies: Bodies,
}

impl ExtrudedGrid {
    /// Bodies up to this size from corner to corner are furniture \[m\].
    pub const FURNITURE: f64 = 1.5;

    /// A grid whose walls are `height` high \[m\].
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] unless the height is positive.
    pub fn new(grid: OccupancyGrid, height: f64) -> Result<Self> {
        positive("height of walls [m]", height)?;
        Ok(ExtrudedGrid { bodies: Bodies::of(&grid), grid, height })
    }

    /// The map.
    pub fn grid(&self) -> &OccupancyGrid {
        &self.grid
    }

    /// Height of the body that an occupied cell belongs to \[m\]; `None` for cells that are not.
    fn height_of(&self, index: usize) -> Option<(u32, f64)> {
        let body = self.bodies.at(index)?;
        let extent = self.bodies.extent(body) * self.grid.resolution();
        // Stools, tables, cupboards: 0.35 m to 1.2 m, by the number that the place hashes to.
        let low = 0.35 + 0.85 * f64::from(paint::hash(body) % 100) / 100.0;
        let height = if extent > Self::FURNITURE { self.height } else { low.min(self.height) };
        Some((body, height))
    }
}

impl WallWorld for ExtrudedGrid {
    fn visit_walls(
        &self,
        origin: &Point2<f64>,
        direction: f64,
        max_range: f64,
        visit: &mut dyn FnMut(WallHit) -> bool,
    ) {
        let (sin, cos) = direction.sin_cos();
        let frame = self.grid.frame();
        let Some(ray) = GridRay::new(frame, origin, [cos, sin], max_range) else { return };
        let mut inside = None;
        for cell in Traversal::new(frame, &ray) {
            let body = frame.index(cell).and_then(|index| self.height_of(index));
            if let Some((body, height)) = body
                && inside != Some(body)
            {
                let range = ray.entry_of([cell.column, cell.row]) * frame.resolution();
                let place = Point2::new(origin.x + range * cos, origin.y + range * sin);
                let furniture = height < self.height;
                let color = paint::color(&self.grid, cell, &place, furniture.then_some(body));
                if !visit(WallHit { range, height, color }) {
                    return;
                }
            }
            inside = body.map(|(body, _)| body);
        }
    }

    fn floor_color(&self) -> Rgb {
        [133, 120, 104]
    }
}

/// Whether a value stands for an obstacle.
fn occupied(value: i8) -> bool {
    Occupancy::of(value) == Occupancy::Occupied
}
