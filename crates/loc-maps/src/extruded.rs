//! A grid with walls that have heights and colours, for simulated cameras.
//!
//! A floor plan has no heights. Here every connected piece of occupied cells becomes a body: a
//! long one is a wall of full height, a small one is furniture, which is lower, so that a camera
//! sees over it. Walls are shaded by the direction they face, and have a faint pattern of panels;
//! furniture has colours. All of it is a function of the map alone.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_maps::ExtrudedGrid;
//! use loc_maps::grid::{Cell, GridFrame, OccupancyGrid};
//! use loc_sensors::world::WallWorld;
//! let mut grid = OccupancyGrid::filled(GridFrame::new(100, 60, 0.1, Pose2::IDENTITY)?, 0);
//! (0..60).try_for_each(|row| grid.set(Cell::new(90, row), 100))?;
//! grid.set(Cell::new(50, 30), 100)?;
//! let rooms = ExtrudedGrid::new(grid, 2.5)?;
//! let mut heights = Vec::new();
//! rooms.visit_walls(&[1.0, 3.05].into(), 0.0, 20.0, &mut |wall| {
//!     heights.push(wall.height);
//!     true
//! });
//! assert!(heights.len() == 2 && heights[0] < 1.5, "a stool before a wall");
//! assert_eq!(heights[1], 2.5);
//! # Ok::<(), loc_maps::Error>(())
//! ```

use crate::Result;
use crate::grid::{Cell, Occupancy, OccupancyGrid};
use crate::raycast::{GridRay, Traversal};
use loc_core::error::positive;
use loc_sensors::world::{Rgb, WallHit, WallWorld};
use nalgebra::{Point2, Vector2};

/// An occupancy grid as a world of walls and furniture.
#[derive(Debug, Clone)]
pub struct ExtrudedGrid {
    grid: OccupancyGrid,
    height: f64,
    bodies: Bodies,
}

impl ExtrudedGrid {
    /// Bodies up to this size from corner to corner are furniture \[m\].
    pub const FURNITURE: f64 = 1.5;

    /// A grid whose walls are `height` high \[m\].
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] unless the height is positive.
    pub fn new(grid: OccupancyGrid, height: f64) -> Result<Self> {
        positive("height of walls [m]", height)?;
        Ok(ExtrudedGrid { bodies: Bodies::of(&grid), grid, height })
    }

    /// The map.
    pub fn grid(&self) -> &OccupancyGrid {
        &self.grid
    }

    /// Height of the body that an occupied cell belongs to \[m\]; `None` for cells that are not.
    fn height_of(&self, index: usize) -> Option<(u32, f64)> {
        let body = self.bodies.at(index)?;
        let extent = self.bodies.extent(body) * self.grid.resolution();
        // Stools, tables, cupboards: 0.35 m to 1.2 m, by a hash of the body's number.
        let low = 0.35 + 0.85 * f64::from(hash(body) % 100) / 100.0;
        let height = if extent > Self::FURNITURE { self.height } else { low.min(self.height) };
        Some((body, height))
    }
}

impl WallWorld for ExtrudedGrid {
    fn visit_walls(
        &self,
        origin: &Point2<f64>,
        direction: f64,
        max_range: f64,
        visit: &mut dyn FnMut(WallHit) -> bool,
    ) {
        let (sin, cos) = direction.sin_cos();
        let frame = self.grid.frame();
        let Some(ray) = GridRay::new(frame, origin, [cos, sin], max_range) else { return };
        let mut inside = None;
        for cell in Traversal::new(frame, &ray) {
            let body = frame.index(cell).and_then(|index| self.height_of(index));
            if let Some((body, height)) = body
                && inside != Some(body)
            {
                let range = ray.entry_of([cell.column, cell.row]) * frame.resolution();
                let place = Point2::new(origin.x + range * cos, origin.y + range * sin);
                let furniture = height < self.height;
                let color = color(&self.grid, cell, &place, furniture.then_some(body));
                if !visit(WallHit { range, height, color }) {
                    return;
                }
            }
            inside = body.map(|(body, _)| body);
        }
    }

    fn floor_color(&self) -> Rgb {
        [133, 120, 104]
    }
}

/// Whether a value stands for an obstacle.
fn occupied(value: i8) -> bool {
    Occupancy::of(value) == Occupancy::Occupied
}

/// The connected pieces of occupied cells: the body of each cell, and the size of the bodies.
#[derive(Debug, Clone)]
struct Bodies {
    /// 0 for no body, else its number, from 1.
    labels: Vec<u32>,
    /// Diagonal of the box around each body \[cells\].
    extents: Vec<f64>,
}

impl Bodies {
    fn of(grid: &OccupancyGrid) -> Self {
        let mut bodies = Bodies { labels: vec![0; grid.values().len()], extents: Vec::new() };
        for (start, &value) in grid.values().iter().enumerate() {
            if occupied(value) && bodies.labels[start] == 0 {
                let extent = bodies.fill(grid, start);
                bodies.extents.push(extent);
            }
        }
        bodies
    }

    /// The body of the cell at a place of the row-major grid.
    fn at(&self, index: usize) -> Option<u32> {
        self.labels.get(index).copied().filter(|label| *label > 0)
    }

    /// Diagonal of the box around a body \[cells\].
    fn extent(&self, body: u32) -> f64 {
        self.extents.get(body as usize - 1).copied().unwrap_or(0.0)
    }

    /// Labels all that is connected to a cell, over corners too; returns the diagonal.
    fn fill(&mut self, grid: &OccupancyGrid, start: usize) -> f64 {
        let width = grid.width();
        let label = self.extents.len() as u32 + 1;
        let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
        let mut waiting = vec![start];
        self.labels[start] = label;
        while let Some(index) = waiting.pop() {
            let place = [index % width, index / width];
            for axis in 0..2 {
                low[axis] = low[axis].min(place[axis]);
                high[axis] = high[axis].max(place[axis]);
            }
            for row in place[1].saturating_sub(1)..=(place[1] + 1).min(grid.height() - 1) {
                for column in place[0].saturating_sub(1)..=(place[0] + 1).min(width - 1) {
                    let next = row * width + column;
                    if self.labels[next] == 0 && occupied(grid.values()[next]) {
                        self.labels[next] = label;
                        waiting.push(next);
                    }
                }
            }
        }
        f64::hypot((high[0] - low[0] + 1) as f64, (high[1] - low[1] + 1) as f64)
    }
}

/// Radius of the neighbourhood from which the direction of a wall is computed \[cells\].
const AROUND: isize = 4;
/// Width of the panels of walls \[m\].
const PANEL: f64 = 1.0;
/// Direction of the light \[rad\].
const LIGHT: f64 = 0.9;

const WALL: [f64; 3] = [236.0, 230.0, 214.0];
const FURNITURE: [[f64; 3]; 6] = [
    [206.0, 92.0, 60.0],
    [72.0, 126.0, 176.0],
    [94.0, 150.0, 84.0],
    [222.0, 172.0, 70.0],
    [140.0, 98.0, 164.0],
    [80.0, 160.0, 158.0],
];

/// The colour of the surface that is met in a cell at a place \[m\]; `furniture` is the number of
/// its body.
fn color(grid: &OccupancyGrid, cell: Cell, place: &Point2<f64>, furniture: Option<u32>) -> Rgb {
    let facing = facing(grid, cell);
    let light = Vector2::new(LIGHT.cos(), LIGHT.sin());
    let shade = 0.74 + 0.24 * facing.dot(&light);
    let panel = |coordinate: f64| (coordinate / PANEL).floor() as i64;
    let base = match furniture {
        Some(body) => FURNITURE[hash(body) as usize / 7 % FURNITURE.len()],
        None if (panel(place.x) + panel(place.y)).rem_euclid(2) == 0 => WALL,
        None => WALL.map(|value| 0.9 * value),
    };
    // A cast of a float to an integer saturates.
    base.map(|value| (value * shade).round() as u8)
}

/// The direction from the wall into the free space before it, a unit vector; zero for a cell that
/// walls or free cells surround evenly.
fn facing(grid: &OccupancyGrid, cell: Cell) -> Vector2<f64> {
    let mut sum = Vector2::zeros();
    for dy in -AROUND..=AROUND {
        for dx in -AROUND..=AROUND {
            let (column, row) =
                (cell.column.checked_add_signed(dx), cell.row.checked_add_signed(dy));
            let (Some(column), Some(row)) = (column, row) else { continue };
            let free = grid.value(Cell::new(column, row)).is_some_and(|v| !occupied(v));
            if free && dx * dx + dy * dy <= AROUND * AROUND {
                sum += Vector2::new(dx as f64, dy as f64);
            }
        }
    }
    let in_map = grid.origin().rotation() * sum;
    in_map.try_normalize(1e-9).unwrap_or_default()
}

/// A hash of small numbers (Knuth's multiplicative hash).
fn hash(value: u32) -> u32 {
    value.wrapping_mul(2_654_435_769) >> 16
}
