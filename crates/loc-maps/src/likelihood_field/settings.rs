//! How the likelihood falls off with the distance to the nearest obstacle.

use super::tiles::Codes;
use super::{LikelihoodField, Scale};
use crate::grid::{Cell, Occupancy, OccupancyGrid, UNKNOWN};
use crate::{DistanceMap, Result};
use loc_core::error::positive;

loc_core::settings! {
    /// Settings of a likelihood field.
    ///
    /// The defaults are sharper than those of nav2_amcl ([`nav2`](Self::nav2)), on the surfaces of
    /// the walls: the filters of this workspace can follow such a field.
    #[derive(Copy)]
    pub struct LikelihoodFieldSettings {
        /// Standard deviation of the distance between a beam's end and its obstacle \[m\]
        /// (`sigma_hit`).
        pub sigma_hit: f64 = 0.05 => positive;
        /// Share of the beams that end on an obstacle of the map (`z_hit`).
        pub z_hit: f64 = 0.8 => non_negative;
        /// Share of the beams that end anywhere (`z_rand`).
        pub z_rand: f64 = 0.2 => positive;
        /// The range over which those are spread \[m\] (`laser_max_range`).
        pub max_range: f64 = 12.0 => positive;
        /// Farther from all obstacles than this, the likelihood stays as it is there \[m\]
        /// (`laser_likelihood_max_dist`).
        pub max_distance: f64 = 2.0 => positive;
        /// Which occupied cells a beam may end on.
        pub obstacles: Obstacles = Obstacles::Surfaces => any;
        /// What the likelihood is in unknown cells.
        pub unknown_space: UnknownSpace = UnknownSpace::default() => check;
        /// What the likelihood is off the map.
        pub off_map: OffMap = OffMap::default() => check;
    }
}

/// Which occupied cells a beam may end on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Obstacles {
    /// All of them, the inside of thick walls too.
    OccupiedCells,
    /// Those that touch a free cell at a side or a corner. No beam ends deep inside a thick wall
    /// or a solid block, so a pose that sees it there is wrong.
    Surfaces,
}

/// What the likelihood of a beam's end is in unknown cells.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum UnknownSpace {
    /// By the distance to the nearest obstacle, as in free ones.
    #[default]
    ByDistance,
    /// This constant \[1/m\]; `1 / max_range` says that nothing is known there.
    Likelihood(f64),
}

impl UnknownSpace {
    /// Checks the likelihood.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] unless it is above 0.
    pub fn check(&self) -> loc_core::Result<()> {
        if let UnknownSpace::Likelihood(likelihood) = *self {
            positive("unknown_space likelihood [1/m]", likelihood)?;
        }
        Ok(())
    }
}

impl OffMap {
    /// Checks the likelihood.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] unless it is above 0.
    pub fn check(&self) -> loc_core::Result<()> {
        if let OffMap::Likelihood(likelihood) = *self {
            positive("off_map likelihood [1/m]", likelihood)?;
        }
        Ok(())
    }
}

/// What the likelihood of a beam's end is off the map.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum OffMap {
    /// As far from all obstacles as `max_distance`, as in nav2_amcl.
    #[default]
    Far,
    /// This constant \[1/m\]; `1 / max_range` says that nothing is known there.
    Likelihood(f64),
}

impl LikelihoodFieldSettings {
    /// The defaults of nav2_amcl, for a sensor of 12 m.
    pub fn nav2() -> Self {
        LikelihoodFieldSettings {
            sigma_hit: 0.2,
            z_hit: 0.5,
            z_rand: 0.5,
            obstacles: Obstacles::OccupiedCells,
            ..LikelihoodFieldSettings::default()
        }
    }

    /// The density of a beam's end at `distance` \[m\] from the nearest obstacle \[1/m\]:
    /// `z_hit N(distance; 0, sigma_hit^2) + z_rand / max_range`.
    ///
    /// nav2_amcl leaves out the normaliser of the Gaussian, see
    /// [`LikelihoodFieldSettings::unnormalised`].
    pub fn likelihood(&self, distance: f64) -> f64 {
        let deviation = distance / self.sigma_hit;
        self.z_hit / self.normaliser() * (-0.5 * deviation * deviation).exp()
            + self.z_rand / self.max_range
    }

    /// The settings whose likelihood is the pz of nav2_amcl,
    /// `z_hit exp(-distance^2 / (2 sigma_hit^2)) + z_rand / max_range`, where these numbers are
    /// those of a nav2 parameter file: `z_hit` times `sigma_hit sqrt(2 pi)`, all else the same.
    #[must_use]
    pub fn unnormalised(self) -> Self {
        LikelihoodFieldSettings { z_hit: self.z_hit * self.normaliser(), ..self }
    }

    /// What the Gaussian is divided by \[m\].
    fn normaliser(&self) -> f64 {
        self.sigma_hit * std::f64::consts::TAU.sqrt()
    }
}

/// Squared distances \[cells^2\] of which the code is looked up; those above are computed.
const LOOKED_UP: u32 = 1 << 20;

pub(super) fn build(
    grid: &OccupancyGrid,
    settings: &LikelihoodFieldSettings,
) -> Result<LikelihoodField> {
    settings.check()?;
    let distances = match settings.obstacles {
        Obstacles::OccupiedCells => DistanceMap::new(grid, settings.max_distance)?,
        Obstacles::Surfaces => DistanceMap::new(&surfaces(grid)?, settings.max_distance)?,
    };
    let scale = scale(settings);
    // The distances are whole numbers, of which a map has few different ones.
    let compute = |squared| scale.code(settings.likelihood(distances.to_metres(squared)).ln());
    let reach = distances.squared().iter().copied().max().unwrap_or(0);
    let by_distance: Vec<u8> = (0..=reach.min(LOOKED_UP)).map(compute).collect();
    let look_up = |squared: u32| {
        by_distance.get(squared as usize).copied().unwrap_or_else(|| compute(squared))
    };
    let unknown = unknown(settings).map(|unknown| scale.code(unknown));

    let frame = *grid.frame();
    let mut codes = Codes::new(&frame, scale.code(off_map(settings)));
    let rows = grid.values().chunks_exact(frame.width());
    let rows = rows.zip(distances.squared().chunks_exact(frame.width()));
    for (row, (values, squared)) in rows.enumerate() {
        for (column, (&value, &squared)) in values.iter().zip(squared).enumerate() {
            let of_unknown = unknown.filter(|_| Occupancy::of(value) == Occupancy::Unknown);
            codes.set(&frame, column, row, of_unknown.unwrap_or_else(|| look_up(squared)));
        }
    }
    Ok(LikelihoodField { frame, settings: *settings, scale, codes })
}

/// The scale from the smallest to the largest log-likelihood that the settings allow.
fn scale(settings: &LikelihoodFieldSettings) -> Scale {
    let of_distance = |distance| settings.likelihood(distance).ln();
    let all = [of_distance(settings.max_distance), of_distance(0.0), off_map(settings)];
    let all = all.into_iter().chain(unknown(settings));
    let (lowest, highest) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    Scale { lowest, step: (highest - lowest).max(f64::MIN_POSITIVE) / 255.0 }
}

/// The log-likelihood in unknown cells, where it has one of its own.
fn unknown(settings: &LikelihoodFieldSettings) -> Option<f64> {
    match settings.unknown_space {
        UnknownSpace::ByDistance => None,
        UnknownSpace::Likelihood(likelihood) => Some(likelihood.ln()),
    }
}

/// The log-likelihood off the map.
pub(super) fn off_map(settings: &LikelihoodFieldSettings) -> f64 {
    match settings.off_map {
        OffMap::Far => settings.likelihood(settings.max_distance).ln(),
        OffMap::Likelihood(likelihood) => likelihood.ln(),
    }
}

/// The grid with those occupied cells only that touch a free one, at a side or a corner.
fn surfaces(grid: &OccupancyGrid) -> Result<OccupancyGrid> {
    let occupancy = |column: usize, row: usize| grid.occupancy(Cell::new(column, row));
    let touches_free = |cell: Cell| {
        let [columns, rows] = [cell.column, cell.row].map(|k| k.saturating_sub(1)..=k + 1);
        rows.into_iter()
            .any(|row| columns.clone().any(|column| occupancy(column, row) == Occupancy::Free))
    };
    let value = |(cell, value)| {
        let inside = Occupancy::of(value) == Occupancy::Occupied && !touches_free(cell);
        if inside { UNKNOWN } else { value }
    };
    OccupancyGrid::new(*grid.frame(), grid.iter().map(value).collect())
}
