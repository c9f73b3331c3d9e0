//! The floor on which a robot can move, and how much room it has there.

use super::ExtractSettings;
use super::clear::without_clutter;
use crate::grid::{GridFrame, Occupancy, OccupancyGrid};
use crate::{DistanceMap, Result};

/// The clearance of every cell.
pub(super) struct Floor {
    pub(super) frame: GridFrame,
    /// Squared distance to the nearest cell that is no floor \[cells^2\], 0 there.
    pub(super) clearance: Vec<u32>,
    /// The same with the furniture still there.
    pub(super) furnished: Vec<u32>,
    /// Squared radius of the robot \[cells^2\].
    pub(super) robot: u32,
}

impl Floor {
    pub(super) fn of(grid: &OccupancyGrid, settings: &ExtractSettings) -> Result<Floor> {
        let cell = grid.resolution();
        let free = without_clutter(grid, settings.max_clutter / cell);
        let frame = *grid.frame();
        let clearance = clearance(frame, &free)?;
        let radius = squared(settings.robot_radius / cell);
        // Where the robot's middle may be, and from there everything that it covers.
        let middles: Vec<bool> = clearance.iter().map(|&far| far > 0 && far >= radius).collect();
        let covered = distances(frame, &middles, true)?;
        let both = covered.iter().zip(&middles);
        let floor: Vec<bool> = both.map(|(&far, &middle)| middle || far < radius).collect();
        let floor: Vec<bool> = floor.iter().zip(&free).map(|(&a, &b)| a && b).collect();
        let free = |&value: &i8| Occupancy::of(value) == Occupancy::Free;
        let free: Vec<bool> = grid.values().iter().map(free).collect();
        let furnished = self::clearance(frame, &free)?;
        Ok(Floor { clearance: self::clearance(frame, &floor)?, furnished, robot: radius, frame })
    }

    /// A squared distance in cells as a distance \[m\].
    pub(super) fn metres(&self, squared: u32) -> f64 {
        f64::from(squared).sqrt() * self.frame.resolution()
    }
}

/// The square of a distance in cells, as far as it goes.
pub(super) fn squared(cells: f64) -> u32 {
    // The cast saturates.
    (cells * cells) as u32
}

/// Squared distances to what is no floor; beyond the grid there is none.
fn clearance(frame: GridFrame, floor: &[bool]) -> Result<Vec<u32>> {
    let mut clearance = distances(frame, floor, false)?;
    let (width, height) = (frame.width(), frame.height());
    for (index, far) in clearance.iter_mut().enumerate() {
        let (column, row) = (index % width, index / width);
        let border = (column + 1).min(row + 1).min(width - column).min(height - row);
        *far = (*far).min(u32::try_from(border * border).unwrap_or(u32::MAX));
    }
    Ok(clearance)
}

/// Squared distances to the cells where a mask has a value.
fn distances(frame: GridFrame, mask: &[bool], value: bool) -> Result<Vec<u32>> {
    let cell = |&is: &bool| {
        let class = if is == value { Occupancy::Occupied } else { Occupancy::Free };
        class.value()
    };
    let grid = OccupancyGrid::new(frame, mask.iter().map(cell).collect())?;
    Ok(DistanceMap::new(&grid, f64::INFINITY)?.squared().to_vec())
}
