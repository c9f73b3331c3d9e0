//! Drawing in metres on the cells of a grid.

use super::{World, WorldSettings};
use crate::grid::{GridFrame, Occupancy};
use crate::{Bounds, Landmark, LandmarkMap, OccupancyGrid, Result};
use loc_core::Pose2;
use nalgebra::Point2;

/// Cells to draw on, all unknown at first.
///
/// Worlds are drawn lying: x along the longer side, from (0, 0) at a corner. Where the grid is
/// higher than wide, the canvas swaps the axes.
pub(super) struct Canvas {
    width: usize,
    height: usize,
    resolution: f64,
    upright: bool,
    cells: Vec<i8>,
}

impl Canvas {
    pub(super) fn new(settings: &WorldSettings) -> Result<Self> {
        settings.checked()?;
        let &WorldSettings { width, height, resolution, .. } = settings;
        let cells = vec![Occupancy::Unknown.value(); width * height];
        Ok(Canvas { width, height, resolution, upright: height > width, cells })
    }

    /// All that can be drawn on \[m\].
    pub(super) fn area(&self) -> Bounds {
        let corner = Point2::new(self.width as f64, self.height as f64) * self.resolution;
        Bounds { min: Point2::origin(), max: self.turned(corner) }
    }

    /// A thickness \[m\], but two cells at least.
    pub(super) fn thickness(&self, wanted: f64) -> f64 {
        wanted.max(2.0 * self.resolution)
    }

    /// The distance \[m\] to keep from the border: the wanted one, less in a world that is small.
    pub(super) fn margin(&self, wanted: f64) -> f64 {
        wanted.min(0.06 * self.area().height())
    }

    /// Gives all cells with their centres in a box one class.
    pub(super) fn fill(&mut self, bounds: &Bounds, class: Occupancy) {
        let [left, bottom] = self.first_cell(bounds.min);
        let [right, top] = self.first_cell(bounds.max);
        for row in self.cells.chunks_exact_mut(self.width).take(top).skip(bottom) {
            if let Some(cells) = row.get_mut(left..right) {
                cells.fill(class.value());
            }
        }
    }

    /// Gives all cells with their centres in a disc one class.
    pub(super) fn disc(&mut self, center: Point2<f64>, radius: f64, class: Occupancy) {
        let bounds = Bounds { min: center, max: center }.grown(radius);
        let [left, bottom] = self.first_cell(bounds.min);
        let [right, top] = self.first_cell(bounds.max);
        let center = self.turned(center) / self.resolution;
        for row in bottom..top {
            for column in left..right {
                let cell = Point2::new(column as f64 + 0.5, row as f64 + 0.5);
                if nalgebra::distance(&cell, &center) * self.resolution <= radius {
                    self.cells[row * self.width + column] = class.value();
                }
            }
        }
    }

    /// Overwrites the half with the greater y with the other one, turned by 180 degrees.
    pub(super) fn repeat_turned(&mut self) {
        let count = self.cells.len();
        for first in 0..count / 2 {
            let second = count - 1 - first;
            let in_order = !self.upright || first % self.width <= second % self.width;
            let [from, to] = if in_order { [first, second] } else { [second, first] };
            self.cells[to] = self.cells[from];
        }
    }

    /// What was drawn, as a world whose lower-left corner is the map's origin.
    pub(super) fn into_world(self, name: &'static str, marks: &[Mark]) -> Result<World> {
        let landmarks = marks.iter().zip(1..).map(|(mark, id)| {
            let Point2 { coords } = self.turned(mark.position);
            Landmark { id, position: [coords.x, coords.y, mark.height].into() }
        });
        let landmarks = LandmarkMap::new(landmarks)?;
        let frame = GridFrame::new(self.width, self.height, self.resolution, Pose2::IDENTITY)?;
        Ok(World { name, grid: OccupancyGrid::new(frame, self.cells)?, landmarks })
    }

    /// The first column and the first row whose centres are not before a point.
    fn first_cell(&self, point: Point2<f64>) -> [usize; 2] {
        let point = self.turned(point) / self.resolution;
        // The casts saturate at 0.
        let [column, row] = [point.x, point.y].map(|along| (along - 0.5).ceil() as usize);
        [column.min(self.width), row.min(self.height)]
    }

    fn turned(&self, point: Point2<f64>) -> Point2<f64> {
        if self.upright { Point2::new(point.y, point.x) } else { point }
    }
}

/// A landmark without a number yet: its position \[m\], still without a number.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mark {
    pub(super) position: Point2<f64>,
    pub(super) height: f64,
}

/// The box between two coordinates along x and two along y.
pub(super) fn bounds(x: [f64; 2], y: [f64; 2]) -> Bounds {
    Bounds { min: Point2::new(x[0], y[0]), max: Point2::new(x[1], y[1]) }
}
