//! The building that a tour leads through, and what is asked of it.

use crate::config::field;
use crate::{Error, Result};
use loc_maps::grid::{Occupancy, io};
use loc_maps::worlds::{self, WorldSettings};
use loc_maps::{DistanceMap, LandmarkMap, OccupancyGrid, RayCaster};
use nalgebra::Point2;
use serde::Deserialize;
use std::path::Path;
use std::sync::Arc;

/// Beyond this, more room makes no difference \[m\].
const WIDE: f64 = 3.0;

/// A generated world, see [`loc_maps::worlds`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorldConfig {
    /// Its name: `office`, `corridor`, `soccer-field` or `hall-of-mirrors`.
    pub name: String,
    /// Number of columns; what suits the kind of world where left out.
    pub width: Option<usize>,
    /// Number of rows.
    pub height: Option<usize>,
    /// Side of a cell.
    pub resolution_m: Option<f64>,
    /// What its details are drawn from, whatever the seed of the run; 1 where left out.
    pub seed: Option<u64>,
}

/// A grid with its walls for rays and its room for robots.
#[derive(Debug)]
pub struct TourWorld {
    pub(super) grid: Arc<OccupancyGrid>,
    pub(super) landmarks: Arc<LandmarkMap>,
    pub(crate) walls: RayCaster,
    clearance: DistanceMap,
}

impl WorldConfig {
    /// The size of the world.
    ///
    /// # Errors
    /// [`Error::UnknownName`] with the names there are.
    pub fn settings(&self) -> Result<WorldSettings> {
        let suited = WorldSettings::suited_to(&self.name).map_err(|_| Error::UnknownName {
            what: "world",
            expected: worlds::NAMES.join(", "),
            found: self.name.clone(),
        })?;
        Ok(WorldSettings {
            width: self.width.unwrap_or(suited.width),
            height: self.height.unwrap_or(suited.height),
            resolution: self.resolution_m.unwrap_or(suited.resolution),
            seed: self.seed.unwrap_or(suited.seed),
        })
    }
}

impl TourWorld {
    /// A generated world, or the map of map_server in a file: one of the two.
    ///
    /// # Errors
    /// [`Error::Config`] for both or none, and those of the world or the file.
    pub fn open(world: Option<&WorldConfig>, map: Option<&Path>) -> Result<Self> {
        match (world, map) {
            (Some(world), None) => {
                let world = worlds::by_name(&world.name, &world.settings()?)?;
                let landmarks = Arc::new(world.landmarks);
                Ok(TourWorld { landmarks, ..TourWorld::new(world.grid)? })
            }
            (None, Some(file)) => TourWorld::new(io::load(file)?),
            (Some(_), Some(_)) => Err(field("world, map", "one of the two", "both")),
            (None, None) => Err(field("world, map", "one of the two", "none")),
        }
    }

    /// A grid as a world, without landmarks.
    ///
    /// # Errors
    /// Those of [`DistanceMap::to_cells`].
    pub fn new(grid: OccupancyGrid) -> Result<Self> {
        let blocks = |value| Occupancy::of(value) != Occupancy::Free;
        let clearance = DistanceMap::to_cells(&grid, WIDE, blocks)?;
        let (walls, landmarks) = (RayCaster::new(&grid), Arc::default());
        Ok(TourWorld { grid: Arc::new(grid), landmarks, walls, clearance })
    }

    /// The map.
    pub fn grid(&self) -> &Arc<OccupancyGrid> {
        &self.grid
    }

    /// The map, prepared for casting rays.
    pub fn walls(&self) -> &RayCaster {
        &self.walls
    }

    /// Distance to what is not free \[m\], at most 3 m; 0 off the map.
    pub fn clearance(&self, point: &Point2<f64>) -> f64 {
        self.clearance.distance_at(point).unwrap_or(0.0)
    }
}
