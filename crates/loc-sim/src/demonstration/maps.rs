//! The kinds of maps, made of one another (C1 to C6).
//!
//! A generated world is a grid. Of the grid are made the lines of its walls, the points of its
//! obstacles, its rooms and doors as a graph, and the likelihood field that the distance to the
//! nearest obstacle gives; of the lines a grid again. The world brings its landmarks along.

use super::Demonstration;
use crate::Result;
use crate::output::Illustration;
use crate::output::figures::FigureFile;
use crate::source::tour::WorldConfig;
use loc_core::error::positive;
use loc_maps::convert::Surface;
use loc_maps::grid::Cell;
use loc_maps::likelihood_field::{LikelihoodField, LikelihoodFieldSettings};
use loc_maps::worlds::{self, World};
use loc_maps::{LineMap, MapPicture, OccupancyGrid, PointMap, TopologicalMap};
use loc_plot::color::Image;
use loc_plot::{Backdrop, Scene};
use serde::Deserialize;
use serde_json::json;

/// The world, and how its maps are made.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapsConfig {
    /// The world.
    pub world: WorldConfig,
    /// The field.
    #[serde(default = "LikelihoodFieldSettings::nav2")]
    pub field: LikelihoodFieldSettings,
}

impl Demonstration for MapsConfig {
    fn check(&self) -> Result<()> {
        self.world.settings()?;
        positive("demonstration.field.sigma_hit", self.field.sigma_hit)?;
        Ok(())
    }

    fn run(&self, _title: &str, _seed: u64) -> Result<Illustration> {
        let maps = Maps::new(self)?;
        let cells = maps.world.grid.width() * maps.world.grid.height();
        let (lines, points) = (maps.lines.len(), maps.points.len());
        let (places, bytes) = (maps.places.places().len(), maps.field.bytes());
        let rows = [
            ("C1", "occupancy grid", "cells", cells, cells),
            ("C2", "line map", "lines", lines, 32 * lines),
            ("C3", "point map", "points", points, 16 * points),
            ("C4", "topological map", "places", places, 0),
            ("C5", "likelihood field", "bytes", bytes, bytes),
            ("C6", "landmark map", "landmarks", maps.world.landmarks.len(), 0),
        ];
        let lines = rows.iter().map(|(id, name, unit, count, bytes)| match bytes {
            0 => format!("{id}  {name:<18}{count:>8} {unit}"),
            _ => format!("{id}  {name:<18}{count:>8} {unit:<10}{bytes:>9} bytes"),
        });
        let counts = rows.iter().map(|(id, name, unit, count, _)| {
            json!({"id": id, "name": name, "unit": unit, "count": count})
        });
        let summary = json!({"maps": counts.collect::<Vec<_>>()});
        Ok(Illustration::new(lines.collect(), summary, maps.figures()))
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

    /// A picture of each map.
    fn figures(&self) -> Vec<FigureFile> {
        let (grid, landmarks) = (&self.world.grid, &self.world.landmarks);
        let file = |name: &'static str, caption: &'static str, picture: MapPicture| {
            FigureFile::new(name, caption, picture.to_svg())
        };
        let with_landmarks = |picture: MapPicture| match landmarks.is_empty() {
            true => picture,
            false => picture.landmarks(landmarks),
        };
        vec![
            file(
                "grid.svg",
                "C1: occupancy grid, with the landmarks (C6) of the world",
                with_landmarks(MapPicture::new().grid(grid)),
            ),
            file(
                "lines.svg",
                "C2: its walls as lines, over the grid drawn of them",
                MapPicture::new().grid(&self.redrawn).lines(&self.lines),
            ),
            file(
                "points.svg",
                "C3: its obstacles as points",
                MapPicture::new().points(&self.points),
            ),
            file(
                "places.svg",
                "C4: its rooms, corridors and doors",
                MapPicture::new().grid(grid).places(&self.places),
            ),
            self.field_figure(),
        ]
    }

    /// The likelihood field as an image: the darker, the more likely a beam ends there.
    fn field_figure(&self) -> FigureFile {
        let frame = self.field.frame();
        let (columns, rows) = (frame.width(), frame.height());
        let cells = (0..rows).rev().flat_map(|row| (0..columns).map(move |column| (column, row)));
        let value =
            |(column, row)| self.field.log_likelihood_at(&frame.center(Cell::new(column, row)));
        let values: Vec<f64> = cells.map(value).collect();
        let min = values.iter().copied().fold(f64::INFINITY, f64::min);
        let max = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let shade = |value: f64| (255.0 * (max - value) / (max - min).max(1e-12)).round() as u8;
        let pixels = values.into_iter().map(|value| [shade(value); 3]).collect();
        let (origin, cell) = (frame.origin(), frame.resolution());
        let backdrop = Backdrop {
            min: (origin.x, origin.y),
            max: (origin.x + columns as f64 * cell, origin.y + rows as f64 * cell),
            data_uri: Image { width: columns, pixels }.data_uri(),
        };
        let scene = Scene::new("Likelihood field (C5)")
            .subtitle(format!("ln p of a beam's end, from {min:.2} (white) to {max:.2} (black)"))
            .backdrop(backdrop);
        FigureFile::new("field.svg", "C5: how likely a beam ends where", scene.render())
    }
}
