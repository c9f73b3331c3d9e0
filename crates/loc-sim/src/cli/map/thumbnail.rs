//! A map in a terminal: two cells of the picture in each character.

use loc_core::Pose2;
use loc_maps::OccupancyGrid;
use loc_maps::grid::{Cell, GridFrame, Occupancy};

/// The class of a part of the map: occupied if any of its cells is, else free if any is.
fn class(grid: &OccupancyGrid, columns: (usize, usize), rows: (usize, usize)) -> Occupancy {
    let mut seen = Occupancy::Unknown;
    for row in rows.0..rows.1 {
        for column in columns.0..columns.1 {
            match grid.occupancy(Cell::new(column, row)) {
                Occupancy::Occupied => return Occupancy::Occupied,
                Occupancy::Free => seen = Occupancy::Free,
                Occupancy::Unknown => {}
            }
        }
    }
    seen
}

/// Lines of at most `width` characters: walls `#`, free space blank, the unknown `.`.
pub(super) fn thumbnail(grid: &OccupancyGrid, width: usize) -> Vec<String> {
    let GridFrame { .. } = grid.frame();
    let (w, h) = (grid.width(), grid.height());
    let columns = width.min(w).max(1);
    // A character is about twice as high as it is wide.
    let rows = (h * columns).div_ceil(2 * w).max(1);
    let slice = |k: usize, of: usize, cells: usize| {
        let start = k * cells / of;
        (start, ((k + 1) * cells / of).max(start + 1).min(cells))
    };
    let symbol = |column: usize, row: usize| match class(
        grid,
        slice(column, columns, w),
        slice(row, rows, h),
    ) {
        Occupancy::Occupied => '#',
        Occupancy::Free => ' ',
        Occupancy::Unknown => '.',
    };
    let line = |row: usize| (0..columns).map(|column| symbol(column, row)).collect();
    (0..rows).rev().map(line).collect()
}

/// `(x, y, yaw)` of an origin, as YAML files have it.
pub(super) fn origin(pose: Pose2) -> String {
    format!("({:.3} m, {:.3} m, {:.2} deg)", pose.x, pose.y, pose.theta.to_degrees())
}
