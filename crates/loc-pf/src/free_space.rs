//! Where a robot can be: the free cells of a map, to draw poses from.

use crate::{Error, Result};
use loc_core::Pose2;
use loc_maps::OccupancyGrid;
use loc_maps::grid::{Cell, GridFrame, Occupancy};
use rand::{Rng, RngExt};
use std::f64::consts::PI;

/// The free cells of a grid.
#[derive(Debug, Clone)]
pub struct FreeSpace {
    frame: GridFrame,
    /// Row-major places of the free cells, in order; 4 bytes a free cell.
    cells: Vec<u32>,
}

impl FreeSpace {
    /// The free cells of a map.
    ///
    /// # Errors
    /// [`Error::NoFreeSpace`] where there are none.
    pub fn new(map: &OccupancyGrid) -> Result<Self> {
        let frame = *map.frame();
        let places = map.values().iter().enumerate();
        let free = places.filter(|&(_, &value)| Occupancy::of(value) == Occupancy::Free);
        // A grid has at most 2^28 cells.
        let cells: Vec<u32> = free.map(|(place, _)| place as u32).collect();
        if cells.is_empty() {
            return Err(Error::NoFreeSpace { width: frame.width(), height: frame.height() });
        }
        Ok(FreeSpace { frame, cells })
    }

    /// Free area \[m^2\].
    pub fn area(&self) -> f64 {
        self.cells.len() as f64 * self.frame.resolution().powi(2)
    }

    /// A pose drawn evenly from the free area and all headings.
    pub fn draw<R: Rng + ?Sized>(&self, rng: &mut R) -> Pose2 {
        let place = self.cells[rng.random_range(0..self.cells.len())] as usize;
        let cell = Cell::new(place % self.frame.width(), place / self.frame.width());
        let [u, v]: [f64; 2] = [rng.random(), rng.random()];
        let at = self.frame.to_map(cell.column as f64 + u, cell.row as f64 + v);
        Pose2::new(at.x, at.y, PI * (2.0 * rng.random::<f64>() - 1.0))
    }

    /// Whether a pose lies within the map's rectangle, free or not.
    pub fn is_on_map(&self, pose: Pose2) -> bool {
        self.frame.cell_at(&pose.position()).is_some()
    }

    /// Whether a pose stands in a free cell.
    pub fn contains(&self, pose: Pose2) -> bool {
        let cell = self.frame.cell_at(&pose.position());
        let place = cell.and_then(|cell| self.frame.index(cell));
        place.is_some_and(|place| self.cells.binary_search(&(place as u32)).is_ok())
    }
}
