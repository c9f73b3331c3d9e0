//! The likelihood field (C5): for every place, how likely it is that a laser beam ends there.
//!
//! Beams end on walls, more or less: the likelihood is highest on an obstacle and falls off with
//! the distance to the nearest one. Computed once for a map, it turns the rating of a pose into
//! one lookup for each beam, which is what a particle filter does millions of times a second
//! (Thrun, Burgard and Fox, "Probabilistic Robotics", 2005, section 6.4).
//!
//! The field is stored as one byte a cell, a code that is linear in the logarithm of the
//! likelihood: codes of many beams add up as whole numbers, in any order to the same sum, and
//! become a logarithm once at the end. The cells lie in tiles of 8 x 8, one cache line each, since
//! beams of similar poses end close together in both directions; a margin of one tile catches what
//! falls off the map, so that no lookup asks whether it is inside.
//!
//! What the byte costs: with the default settings a step of the code is 0.0126 in the logarithm of
//! the likelihood, so a beam is off by 0.0063 at most and 0.0036 on the average (root mean
//! square), as much as 0.8 mm of distance are worth at one standard deviation.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_maps::grid::{Cell, GridFrame, OccupancyGrid};
//! use loc_maps::likelihood_field::{Endpoints, LikelihoodField, LikelihoodFieldSettings};
//! let mut grid = OccupancyGrid::filled(GridFrame::new(100, 100, 0.05, Pose2::IDENTITY)?, 0);
//! (0..100).try_for_each(|row| grid.set(Cell::new(80, row), 100))?;
//! let field = LikelihoodField::new(&grid, &LikelihoodFieldSettings::default())?;
//! let scan = Endpoints::from_scan(&[-0.1, 0.0, 0.1], &[2.0, 2.0, 2.0]);
//! let right = field.log_likelihood(Pose2::new(2.0, 2.5, 0.0), &scan);
//! let wrong = field.log_likelihood(Pose2::new(1.5, 2.5, 0.0), &scan);
//! assert!(right > wrong + 3.0);
//! # Ok::<(), loc_maps::Error>(())
//! ```

mod endpoints;
mod settings;
mod tiles;

pub use endpoints::Endpoints;
pub use settings::{LikelihoodFieldSettings, UnknownSpace};

use crate::grid::{GridFrame, Occupancy, OccupancyGrid};
use crate::{DistanceMap, Result};
use loc_core::Pose2;
use nalgebra::Point2;
use tiles::Tiles;

/// The likelihood of a beam's end at every place of a map.
#[derive(Debug, Clone)]
pub struct LikelihoodField {
    frame: GridFrame,
    /// Logarithm of the likelihood of code 0.
    lowest: f64,
    /// What one code adds to it.
    step: f64,
    tiles: Tiles,
}

impl LikelihoodField {
    /// The field of a map.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for settings that are out of range.
    pub fn new(grid: &OccupancyGrid, settings: &LikelihoodFieldSettings) -> Result<Self> {
        settings.validate()?;
        let distances = DistanceMap::new(grid, settings.max_distance)?;
        Ok(LikelihoodField::from_distances(grid, &distances, settings))
    }

    fn from_distances(
        grid: &OccupancyGrid,
        distances: &DistanceMap,
        settings: &LikelihoodFieldSettings,
    ) -> Self {
        let far = settings.likelihood(settings.max_distance).ln();
        let near = settings.likelihood(0.0).ln();
        let unknown = match settings.unknown_space {
            UnknownSpace::ByDistance => None,
            UnknownSpace::Likelihood(likelihood) => Some(likelihood.ln()),
        };
        let lowest = unknown.map_or(far, |unknown| far.min(unknown));
        let highest = unknown.map_or(near, |unknown| near.max(unknown));
        let step = (highest - lowest).max(f64::MIN_POSITIVE) / 255.0;
        let code = |log_likelihood: f64| ((log_likelihood - lowest) / step).round() as u8;

        // The distances are whole numbers, of which a map has few different ones.
        let reach = distances.squared().iter().copied().max().unwrap_or(0);
        let likelihood = |squared| settings.likelihood(distances.to_metres(squared)).ln();
        let by_distance: Vec<u8> =
            (0..=reach.min(1 << 20)).map(|squared| code(likelihood(squared))).collect();
        let look_up = |squared: u32| {
            by_distance.get(squared as usize).copied().unwrap_or_else(|| code(likelihood(squared)))
        };
        let frame = *grid.frame();
        let mut tiles = Tiles::new(frame.width(), frame.height(), code(far));
        let rows = grid.values().chunks_exact(frame.width());
        let rows = rows.zip(distances.squared().chunks_exact(frame.width()));
        for (row, (values, squared)) in rows.enumerate() {
            for (column, (&value, &squared)) in values.iter().zip(squared).enumerate() {
                let of_unknown = unknown.filter(|_| Occupancy::of(value) == Occupancy::Unknown);
                tiles.set(column, row, of_unknown.map_or_else(|| look_up(squared), code));
            }
        }
        LikelihoodField { frame, lowest, step, tiles }
    }

    /// Size, resolution and origin of the grid.
    pub fn frame(&self) -> &GridFrame {
        &self.frame
    }

    /// Memory of the field \[bytes\].
    pub fn bytes(&self) -> usize {
        self.tiles.bytes()
    }

    /// The logarithm of the likelihood that a beam ends at a point of the map \[m\].
    pub fn log_likelihood_at(&self, point: &Point2<f64>) -> f64 {
        let Point2 { coords } = self.frame.to_cells(point);
        let code = self.tiles.at(coords.x as f32, coords.y as f32);
        self.lowest + self.step * f64::from(code)
    }

    /// The logarithm of the likelihood of beams that end at `endpoints`, seen from the pose whose
    /// frame they are given in: the sum over the beams.
    pub fn log_likelihood(&self, pose: Pose2, endpoints: &Endpoints) -> f64 {
        let from = self.frame.to_cells(&pose.position());
        // Single precision turns a beam of 30 m by 5 um at most.
        let (sin, cos) = ((pose.theta - self.frame.origin().theta) as f32).sin_cos();
        let scale = (1.0 / self.frame.resolution()) as f32;
        let turn = [cos * scale, sin * scale];
        let sum = self.tiles.sum([from.x as f32, from.y as f32], turn, endpoints);
        endpoints.len() as f64 * self.lowest + self.step * sum as f64
    }
}
