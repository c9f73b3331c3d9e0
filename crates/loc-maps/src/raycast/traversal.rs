//! Exact traversal: every cell that a ray passes, in order.

use super::GridRay;
use crate::grid::{Cell, GridFrame, OCCUPIED_FROM, OccupancyGrid};
use loc_sensors::world::RangeWorld;
use nalgebra::Point2;

/// The cells that a ray passes on a grid, from its start to its end.
///
/// ```
/// use loc_core::Pose2;
/// use loc_maps::grid::{Cell, GridFrame};
/// use loc_maps::raycast::{GridRay, Traversal};
/// let frame = GridFrame::new(5, 5, 1.0, Pose2::IDENTITY)?;
/// let ray = GridRay::new(&frame, &[0.5, 0.5].into(), [0.8, 0.6], 2.0);
/// let cells: Vec<_> = ray.map(|ray| Traversal::new(&frame, &ray)).into_iter().flatten().collect();
/// assert_eq!(cells, [(0, 0), (1, 0), (1, 1), (2, 1)].map(|(u, v)| Cell::new(u, v)));
/// # Ok::<(), loc_maps::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Traversal {
    walk: Walk,
    width: usize,
}

/// The walk over the places of a row-major grid.
///
/// Which axis comes next is kept as one whole number: how much sooner the ray meets the next edge
/// along x than along y (negative: x first). A step then takes no unpredictable branch.
#[derive(Debug, Clone)]
struct Walk {
    index: usize,
    /// Steps left.
    left: usize,
    sooner: i64,
    /// What a step along x, or along y, changes.
    along_x: (i64, isize),
    along_y: (i64, isize),
}

impl Traversal {
    /// The cells of a ray that was cut to this grid.
    pub fn new(frame: &GridFrame, ray: &GridRay) -> Self {
        Traversal { walk: Walk::new(frame, ray), width: frame.width() }
    }
}

impl Iterator for Traversal {
    type Item = Cell;
    fn next(&mut self) -> Option<Cell> {
        let index = self.walk.next()?;
        Some(Cell::new(index % self.width, index / self.width))
    }
}

impl Walk {
    fn new(frame: &GridFrame, ray: &GridRay) -> Self {
        let size = [frame.width(), frame.height()];
        let first = [0, 1].map(|axis| ray.cell(axis, ray.enter, size[axis]));
        let last = [0, 1].map(|axis| ray.cell(axis, ray.leave, size[axis]));
        // Lengths as whole numbers, counted from where the ray enters: none is longer than
        // width + height, except to edges that it never meets.
        let unit = 2.0_f64.powi(61 - (size[0] + size[1]).ilog2() as i32 - 1);
        let whole = |length: f64| (length * unit).min(2.0_f64.powi(61)) as i64;
        let step = |axis: usize| ray.inverse[axis].abs().min(2.0_f64.powi(61));
        let to_next = |axis: usize| whole(ray.entry(axis, first[axis]) + step(axis) - ray.enter);
        let forward = |axis: usize| if ray.direction[axis] < 0.0 { -1 } else { 1 };
        let next =
            [0, 1].map(|axis| if first[axis] == last[axis] { i64::MAX / 2 } else { to_next(axis) });
        Walk {
            index: first[1] * size[0] + first[0],
            left: first[0].abs_diff(last[0]) + first[1].abs_diff(last[1]) + 1,
            sooner: next[0] - next[1],
            along_x: (whole(step(0)), forward(0)),
            along_y: (-whole(step(1)), forward(1) * size[0] as isize),
        }
    }
}

impl Iterator for Walk {
    type Item = usize;
    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        self.left = self.left.checked_sub(1)?;
        let index = self.index;
        let along_x = self.sooner < 0;
        let (later, places) = if along_x { self.along_x } else { self.along_y };
        self.sooner = self.sooner.wrapping_add(later);
        self.index = index.wrapping_add_signed(places);
        Some(index)
    }
}

impl RangeWorld for OccupancyGrid {
    fn cast(&self, origin: &Point2<f64>, direction: f64, max_range: f64) -> Option<f64> {
        let (sin, cos) = direction.sin_cos();
        let ray = GridRay::new(self.frame(), origin, [cos, sin], max_range)?;
        let values = self.values();
        let mut walk = Walk::new(self.frame(), &ray);
        let hit = walk.find(|&index| values.get(index).is_some_and(|&v| v >= OCCUPIED_FROM))?;
        let length = ray.entry_of([hit % self.width(), hit / self.width()]);
        Some(length * self.resolution())
    }
}
