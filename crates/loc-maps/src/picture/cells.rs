//! The cells of a grid as shapes: rectangles of equal cells, as few as are easily found.

use super::n;
use crate::Bounds;
use crate::grid::{Occupancy, OccupancyGrid};
use std::fmt::Write as _;

/// Equal cells side by side: first column, and the one behind the last.
type Run = (usize, usize);

/// A grid as SVG, in units of cells under a transform of its frame.
pub(super) fn draw(grid: &OccupancyGrid) -> String {
    let (origin, size) = (grid.origin(), grid.resolution());
    let place = format!(
        "translate({} {}) rotate({}) scale({size} {})",
        n(origin.x),
        n(-origin.y),
        n(-origin.theta.to_degrees()),
        -size
    );
    let (width, height) = (grid.width(), grid.height());
    let free = outlines(grid, Occupancy::Free);
    let occupied = outlines(grid, Occupancy::Occupied);
    format!(
        "<g class=\"grid\" transform=\"{place}\" shape-rendering=\"crispEdges\">\n\
         <path fill=\"#cdcdcd\" d=\"M0 0h{width}v{height}h-{width}z\"/>\n\
         <path fill=\"#fff\" d=\"{free}\"/>\n<path fill=\"#000\" d=\"{occupied}\"/>\n</g>\n"
    )
}

/// The box around all cells of which something is known.
pub(super) fn known(grid: &OccupancyGrid) -> Option<Bounds> {
    let known = |value: &i8| Occupancy::of(*value) != Occupancy::Unknown;
    let corners = (0..grid.height()).filter_map(|row| {
        let values = grid.row(row);
        let (first, last) = (values.iter().position(known)?, values.iter().rposition(known)?);
        let corner = |column: usize, row: usize| grid.frame().to_map(column as f64, row as f64);
        let ends = [corner(first, row), corner(last + 1, row)];
        Some(ends.into_iter().chain([corner(first, row + 1), corner(last + 1, row + 1)]))
    });
    Bounds::around(corners.flatten())
}

/// Rectangles that together are the cells of a class: runs of a row that repeat in the rows above
/// grow upwards.
fn outlines(grid: &OccupancyGrid, class: Occupancy) -> String {
    let mut path = String::new();
    let mut open: Vec<(Run, usize)> = Vec::new();
    for row in 0..=grid.height() {
        let runs = runs(grid.row(row), class);
        let mut still = Vec::with_capacity(runs.len());
        // Both are in order of their columns.
        let mut old = open.into_iter().peekable();
        for run in runs {
            while let Some(ended) = old.next_if(|(other, _)| *other < run) {
                close(&mut path, ended, row);
            }
            let since = old.next_if(|(other, _)| *other == run).map_or(row, |(_, since)| since);
            still.push((run, since));
        }
        old.for_each(|ended| close(&mut path, ended, row));
        open = still;
    }
    path
}

fn close(path: &mut String, ((from, to), since): (Run, usize), row: usize) {
    let (width, height) = (to - from, row - since);
    // Writing to a string cannot fail.
    let _ = write!(path, "M{from} {since}h{width}v{height}h-{width}z");
}

fn runs(row: &[i8], class: Occupancy) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for (column, _) in row.iter().enumerate().filter(|(_, v)| Occupancy::of(**v) == class) {
        match runs.last_mut() {
            Some(last) if last.1 == column => last.1 += 1,
            _ => runs.push((column, column + 1)),
        }
    }
    runs
}
