//! From a grid to its likelihood field.

use super::codes::Codes;
use super::settings::{LikelihoodFieldSettings, Obstacles, OffMap, UnknownSpace};
use super::{LikelihoodField, Scale};
use crate::grid::{Cell, Occupancy, OccupancyGrid, UNKNOWN};
use crate::{DistanceMap, Result};

/// Squared distances \[cells^2\] of which the code is looked up; those above are computed.
const LOOKED_UP: u32 = 1 << 20;

pub(super) fn build(
    grid: &OccupancyGrid,
    settings: &LikelihoodFieldSettings,
) -> Result<LikelihoodField> {
    settings.validate()?;
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

/// The scale from the least to the greatest log-likelihood that the settings allow.
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
