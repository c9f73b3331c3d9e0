//! Drawing into a grid in metres.

use super::WorldSize;
use crate::Result;
use crate::grid::{GridFrame, OccupancyGrid};
use loc_core::Pose2;

/// Thickness of walls \[m\].
pub(super) const WALL: f64 = 0.15;

/// A rectangle \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rect {
    pub(super) left: f64,
    pub(super) bottom: f64,
    pub(super) right: f64,
    pub(super) top: f64,
}

/// A world being drawn; coordinates in metres from its lower-left corner.
#[derive(Debug)]
pub(super) struct Canvas {
    frame: GridFrame,
    cells: Vec<i8>,
    pub(super) width: f64,
    pub(super) height: f64,
}

impl Rect {
    pub(super) fn new(left: f64, bottom: f64, width: f64, height: f64) -> Self {
        Rect { left, bottom, right: left + width, top: bottom + height }
    }

    pub(super) fn width(&self) -> f64 {
        self.right - self.left
    }

    pub(super) fn height(&self) -> f64 {
        self.top - self.bottom
    }

    pub(super) fn overlaps(&self, other: &Rect) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.bottom < other.top
            && other.bottom < self.top
    }

    /// The rectangle made smaller on all sides; larger for a negative margin.
    pub(super) fn inset(&self, margin: f64) -> Rect {
        Rect {
            left: self.left + margin,
            bottom: self.bottom + margin,
            right: self.right - margin,
            top: self.top - margin,
        }
    }
}

impl Canvas {
    /// An empty world of at least `least` \[m\] in width and height.
    pub(super) fn new(size: WorldSize, origin: Pose2, least: (f64, f64)) -> Result<Self> {
        let frame = GridFrame::new(size.columns, size.rows, size.resolution, origin)?;
        let (width, height) =
            (size.columns as f64 * size.resolution, size.rows as f64 * size.resolution);
        let too_small =
            |what, expected, found| loc_core::Error::OutOfRange { what, expected, found };
        if size.resolution > 0.5 * WALL {
            let expected = "at most 0.075, half a wall";
            return Err(too_small("resolution of a world [m]", expected, size.resolution).into());
        }
        if width < least.0 {
            return Err(too_small("width of the world [m]", "room for its parts", width).into());
        }
        if height < least.1 {
            return Err(too_small("height of the world [m]", "room for its parts", height).into());
        }
        Ok(Canvas { frame, cells: vec![0; frame.cell_count()], width, height })
    }

    /// Gives all cells whose centre lies in a rectangle a value.
    pub(super) fn fill(&mut self, rect: Rect, value: i8) {
        self.paint(rect, value, |_, _| true);
    }

    /// The same for a disc.
    pub(super) fn disc(&mut self, x: f64, y: f64, radius: f64, value: i8) {
        let rect = Rect::new(x - radius, y - radius, 2.0 * radius, 2.0 * radius);
        self.paint(rect, value, |u, v| (u - x).hypot(v - y) <= radius);
    }

    /// A wall all round the inside of a rectangle.
    pub(super) fn frame(&mut self, rect: Rect, value: i8) {
        let Rect { left, bottom, .. } = rect;
        self.fill(Rect::new(left, bottom, rect.width(), WALL), value);
        self.fill(Rect::new(left, rect.top - WALL, rect.width(), WALL), value);
        self.fill(Rect::new(left, bottom, WALL, rect.height()), value);
        self.fill(Rect::new(rect.right - WALL, bottom, WALL, rect.height()), value);
    }

    /// The whole world.
    pub(super) fn whole(&self) -> Rect {
        Rect::new(0.0, 0.0, self.width, self.height)
    }

    pub(super) fn into_grid(self) -> OccupancyGrid {
        OccupancyGrid::from_valid(self.frame, self.cells)
    }

    fn paint(&mut self, rect: Rect, value: i8, holds: impl Fn(f64, f64) -> bool) {
        let resolution = self.frame.resolution();
        let first = |edge: f64| (edge / resolution - 0.5).ceil().max(0.0) as usize;
        let columns = first(rect.left)..first(rect.right).min(self.frame.width());
        for row in first(rect.bottom)..first(rect.top).min(self.frame.height()) {
            for column in columns.clone() {
                let center = |k: usize| (k as f64 + 0.5) * resolution;
                let cell = self.cells.get_mut(row * self.frame.width() + column);
                if let Some(cell) = cell.filter(|_| holds(center(column), center(row))) {
                    *cell = value;
                }
            }
        }
    }
}
