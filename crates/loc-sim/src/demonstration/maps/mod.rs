//! The kinds of maps, made of one another (C1 to C6).
//!
//! A generated world is a grid. Of the grid are made the lines of its walls, the points of its
//! obstacles, its rooms and doors as a graph, and the likelihood field that the distance to the
//! nearest obstacle gives; of the lines a grid again. The world brings its landmarks along.

mod figure;

use crate::Result;
use crate::output::Illustration;
use crate::source::tour::WorldConfig;
use loc_core::error::positive;
use loc_maps::convert::Surface;
use loc_maps::likelihood_field::{LikelihoodField, LikelihoodFieldSettings};
use loc_maps::worlds::{self, World};
use loc_maps::{LineMap, OccupancyGrid, PointMap, TopologicalMap};
use serde::Deserialize;
use serde_json::json;

/// The world, and how its maps are made.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapsConfig {
    /// The world.
    pub world: WorldConfig,
    /// The field.
    #[serde(default)]
    pub field: LikelihoodFieldSettings,
}

impl MapsConfig {
    pub(super) fn check(&self) -> Result<()> {
        self.world.settings()?;
        positive("demonstration.field.sigma_hit", self.field.sigma_hit)?;
        Ok(())
    }
}

/// One world as every kind of map.
#[derive(Debug)]
pub struct Maps {
    /// The world: a grid (C1) and its landmarks (C6).
    pub world: World,
    /// Its walls as lines (C2).
    pub lines: LineMap,
    /// A grid of the lines.
    pub redrawn: OccupancyGrid,
    /// Its obstacles as points (C3).
    pub points: PointMap,
    /// Its places (C4).
    pub places: TopologicalMap,
    /// How likely a beam ends where (C5).
    pub field: LikelihoodField,
}

impl Maps {
    /// Makes every map.
    ///
    /// # Errors
    /// What the conversions report.
    pub fn new(config: &MapsConfig) -> Result<Self> {
        config.check()?;
        let world = worlds::by_name(&config.world.name, &config.world.settings()?)?;
        let lines = LineMap::from_grid(&world.grid, &Default::default())?;
        Ok(Maps {
            redrawn: lines.to_grid(world.grid.resolution(), 0.5)?,
            points: PointMap::from_grid(&world.grid, Surface::Boundary)?,
            places: TopologicalMap::from_grid(&world.grid, &Default::default())?,
            field: LikelihoodField::new(&world.grid, &config.field)?,
            lines,
            world,
        })
    }

    /// The maps as figures, with their sizes.
    pub fn illustrate(&self) -> Illustration {
        let grid = &self.world.grid;
        let rows = [
            (
                "C1",
                "occupancy grid",
                "cells",
                grid.width() * grid.height(),
                grid.width() * grid.height(),
            ),
            ("C2", "line map", "lines", self.lines.len(), 32 * self.lines.len()),
            ("C3", "point map", "points", self.points.len(), 16 * self.points.len()),
            ("C4", "topological map", "places", self.places.places().len(), 0),
            ("C5", "likelihood field", "bytes", self.field.bytes(), self.field.bytes()),
            ("C6", "landmark map", "landmarks", self.world.landmarks.len(), 0),
        ];
        let lines = rows.iter().map(|(id, name, unit, count, bytes)| match bytes {
            0 => format!("{id}  {name:<18}{count:>8} {unit}"),
            _ => format!("{id}  {name:<18}{count:>8} {unit:<10}{bytes:>9} bytes"),
        });
        let lines = lines.collect();
        let counts = rows.iter().map(|(id, name, unit, count, _)| {
            json!({"id": id, "name": name, "unit": unit, "count": count})
        });
        let summary = json!({"maps": counts.collect::<Vec<_>>()});
        Illustration::new(lines, summary, figure::figures(self))
    }
}
