//! First pass: how far each cell is from an obstacle in its own column.

use crate::grid::OccupancyGrid;

/// Steps to the nearest obstacle up or down the column, at most `reach`, in row-major order.
///
/// Whole rows are compared with their neighbour below, then above: no row waits for itself, so
/// that the compiler handles many columns at once.
pub(super) fn distances(
    grid: &OccupancyGrid,
    reach: i16,
    is_obstacle: impl Fn(i8) -> bool,
) -> Vec<i16> {
    let width = grid.width();
    // A value is judged once, not once a cell.
    let table: [i16; 256] =
        std::array::from_fn(|byte| if is_obstacle(byte as u8 as i8) { 0 } else { reach });
    let start = grid.values().iter().map(|&value| table[usize::from(value as u8)]);
    let mut steps: Vec<i16> = start.collect();
    let mut upward = steps.chunks_exact_mut(width);
    let mut below = upward.next();
    for row in upward {
        if let Some(below) = below {
            advance(row, below);
        }
        below = Some(row);
    }
    let mut downward = steps.chunks_exact_mut(width).rev();
    let mut above = downward.next();
    for row in downward {
        if let Some(above) = above {
            advance(row, above);
        }
        above = Some(row);
    }
    steps
}

fn advance(row: &mut [i16], neighbour: &[i16]) {
    for (steps, &beside) in row.iter_mut().zip(neighbour) {
        *steps = (*steps).min(beside.saturating_add(1));
    }
}
