//! Taking furniture away.

use crate::grid::{Occupancy, OccupancyGrid};

/// Which cells are floor: the free ones, and islands of others
/// that are at most `longest` cells long and wide.
pub(super) fn without_clutter(grid: &OccupancyGrid, longest: f64) -> Vec<bool> {
    let (width, height) = (grid.width(), grid.height());
    let free = |&value: &i8| Occupancy::of(value) == Occupancy::Free;
    let mut floor: Vec<bool> = grid.values().iter().map(free).collect();
    let mut seen = floor.clone();
    let mut island = Vec::new();
    for start in 0..floor.len() {
        if seen[start] {
            continue;
        }
        seen[start] = true;
        island.clear();
        island.push(start);
        let mut next = 0;
        while let Some(&index) = island.get(next) {
            next += 1;
            for other in around(index, width, height) {
                if !seen[other] {
                    seen[other] = true;
                    island.push(other);
                }
            }
        }
        if extent(&island, width) as f64 <= longest {
            island.iter().for_each(|&index| floor[index] = true);
        }
    }
    floor
}

/// The longer side of the box around some cells \[cells\].
fn extent(cells: &[usize], width: usize) -> usize {
    let span = |places: &mut dyn Iterator<Item = usize>| {
        let (low, high) = places.fold((usize::MAX, 0), |(low, high), k| (low.min(k), high.max(k)));
        high.saturating_sub(low) + 1
    };
    let columns = span(&mut cells.iter().map(|index| index % width));
    columns.max(span(&mut cells.iter().map(|index| index / width)))
}

/// The up to eight neighbours of a cell, by index in row-major order.
#[inline]
pub(super) fn around(index: usize, width: usize, height: usize) -> impl Iterator<Item = usize> {
    let (column, row) = (index % width, index / width);
    let rows = row.saturating_sub(1)..=(row + 1).min(height - 1);
    let columns = column.saturating_sub(1)..=(column + 1).min(width - 1);
    let cells = rows.flat_map(move |row| columns.clone().map(move |c| row * width + c));
    cells.filter(move |&other| other != index)
}
