//! A map in a terminal.

use loc_maps::OccupancyGrid;
use loc_maps::grid::{Cell, Occupancy};

/// From free to all wall.
const SHADES: [char; 5] = [' ', '░', '▒', '▓', '█'];

/// What of a part of the map is of a kind.
#[derive(Default)]
struct Part {
    free: usize,
    occupied: usize,
    unknown: usize,
}

impl Part {
    fn symbol(&self) -> char {
        let known = self.free + self.occupied;
        if known == 0 || self.occupied == 0 && self.unknown > self.free {
            return '·';
        }
        // A wall is thin: a tenth of a part is a wall through it.
        let share = self.occupied as f64 / (known + self.unknown) as f64;
        match share {
            0.0 => SHADES[0],
            s if s < 0.06 => SHADES[1],
            s if s < 0.15 => SHADES[2],
            s if s < 0.4 => SHADES[3],
            _ => SHADES[4],
        }
    }
}

/// The known part of a grid in lines of at most `width` characters: the darker, the more wall;
/// dots are unknown.
pub(super) fn thumbnail(grid: &OccupancyGrid, width: usize) -> Vec<String> {
    let Some((columns, rows)) = known(grid) else {
        return vec!["nothing known".into()];
    };
    let (w, h) = (columns.1 - columns.0, rows.1 - rows.0);
    let across = width.min(w).max(1);
    // A character is about twice as high as it is wide.
    let down = (h * across).div_ceil(2 * w).max(1);
    let slice = |k: usize, of: usize, (start, end): (usize, usize)| {
        let from = start + k * (end - start) / of;
        (from, (start + (k + 1) * (end - start) / of).clamp(from + 1, end.max(from + 1)))
    };
    let line = |row: usize| -> String {
        let rows = slice(row, down, rows);
        (0..across).map(|k| part(grid, slice(k, across, columns), rows).symbol()).collect()
    };
    (0..down).rev().map(line).collect()
}

fn part(grid: &OccupancyGrid, columns: (usize, usize), rows: (usize, usize)) -> Part {
    let mut part = Part::default();
    for row in rows.0..rows.1 {
        for column in columns.0..columns.1 {
            match grid.occupancy(Cell::new(column, row)) {
                Occupancy::Occupied => part.occupied += 1,
                Occupancy::Free => part.free += 1,
                Occupancy::Unknown => part.unknown += 1,
            }
        }
    }
    part
}

/// The columns and rows, from and to, that hold everything known.
fn known(grid: &OccupancyGrid) -> Option<((usize, usize), (usize, usize))> {
    let mut around: Option<((usize, usize), (usize, usize))> = None;
    for (cell, value) in grid.iter() {
        if Occupancy::of(value) == Occupancy::Unknown {
            continue;
        }
        let ((left, right), (bottom, top)) =
            around.unwrap_or(((cell.column, cell.column), (cell.row, cell.row)));
        around = Some((
            (left.min(cell.column), right.max(cell.column + 1)),
            (bottom.min(cell.row), top.max(cell.row + 1)),
        ));
    }
    around
}
