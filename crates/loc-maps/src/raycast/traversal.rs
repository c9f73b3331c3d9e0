//! Exact traversal: every cell that a ray passes, in order; and the part of a ray on a grid.

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

/// A length that no ray reaches, in units of the walk.
const FARTHEST: f64 = (1_u64 << 61) as f64;

/// The traversal of a row-major grid by index.
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
    later: [i64; 2],
    places: [isize; 2],
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
        let unit = (1_u64 << (60 - (size[0] + size[1]).ilog2())) as f64;
        let whole = |length: f64| (length * unit).min(FARTHEST) as i64;
        let step = |axis: usize| ray.inverse[axis].abs().min(FARTHEST);
        let to_next = |axis: usize| whole(ray.entry(axis, first[axis]) + step(axis) - ray.enter);
        let forward = |axis: usize| if ray.direction[axis] < 0.0 { -1 } else { 1 };
        let next =
            [0, 1].map(|axis| if first[axis] == last[axis] { i64::MAX / 2 } else { to_next(axis) });
        Walk {
            index: first[1] * size[0] + first[0],
            left: first[0].abs_diff(last[0]) + first[1].abs_diff(last[1]) + 1,
            sooner: next[0] - next[1],
            later: [whole(step(0)), -whole(step(1))],
            places: [forward(0), forward(1) * size[0] as isize],
        }
    }
}

impl Iterator for Walk {
    type Item = usize;
    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        self.left = self.left.checked_sub(1)?;
        let index = self.index;
        // Both steps are made and one is chosen, which takes two cycles a cell and no branch.
        let [along_x, along_y] = self.later.map(|later| self.sooner.wrapping_add(later));
        let [place_x, place_y] = self.places.map(|places| index.wrapping_add_signed(places));
        let x_first = self.sooner < 0;
        self.sooner = if x_first { along_x } else { along_y };
        self.index = if x_first { place_x } else { place_y };
        Some(index)
    }
}

/// The length at which a ray meets its first occupied cell \[cells\].
#[inline(always)]
fn cast_in_cells(
    grid: &OccupancyGrid,
    start: [f64; 2],
    direction: [f64; 2],
    max_length: f64,
) -> Option<f64> {
    let ray = GridRay::in_cells(grid.frame(), start, direction, max_length)?;
    let values = grid.values();
    let mut walk = Walk::new(grid.frame(), &ray);
    let hit = walk.find(|&index| values.get(index).is_some_and(|&v| v >= OCCUPIED_FROM))?;
    Some(ray.entry_of([hit % grid.width(), hit / grid.width()]))
}

impl RangeWorld for OccupancyGrid {
    fn cast(&self, origin: &Point2<f64>, direction: f64, max_range: f64) -> Option<f64> {
        let Point2 { coords } = self.frame().to_cells(origin);
        let (sin, cos) = direction.sin_cos();
        let along = self.frame().turn_to_grid([cos, sin]);
        let max_length = max_range / self.resolution();
        let length = cast_in_cells(self, [coords.x, coords.y], along, max_length)?;
        Some(length * self.resolution())
    }

    fn cast_fan(
        &self,
        origin: &Point2<f64>,
        first: f64,
        increment: f64,
        max_range: f64,
        ranges: &mut [f64],
    ) {
        let Point2 { coords } = self.frame().to_cells(origin);
        let (start, resolution) = ([coords.x, coords.y], self.resolution());
        fan(self.frame(), first, increment, ranges, |along| {
            Some(cast_in_cells(self, start, along, max_range / resolution)? * resolution)
        });
    }
}

/// A ray's part on a grid. Lengths along it are in cells.
#[derive(Debug, Clone, Copy)]
pub struct GridRay {
    /// Where the ray starts in the grid's frame \[cells\], on the grid or off it.
    pub start: [f64; 2],
    /// Its direction in the grid's frame, a unit vector.
    pub direction: [f64; 2],
    /// What a step of one cell along each axis is in length along the ray; infinite for an axis
    /// that the ray is perpendicular to.
    pub inverse: [f64; 2],
    /// The length at which the ray enters the grid, 0 where it starts inside.
    pub enter: f64,
    /// The length at which it leaves the grid or ends.
    pub leave: f64,
}

impl GridRay {
    /// The part on the grid of the ray from `origin` \[m\] along the unit vector `direction` of the
    /// map, `max_range` \[m\] long; `None` where it passes by, and for numbers that are not finite
    /// (`max_range` may be +inf).
    #[inline]
    pub fn new(
        frame: &GridFrame,
        origin: &Point2<f64>,
        direction: [f64; 2],
        max_range: f64,
    ) -> Option<Self> {
        let start = frame.to_cells(origin);
        let along = frame.turn_to_grid(direction);
        GridRay::in_cells(frame, [start.x, start.y], along, max_range / frame.resolution())
    }

    /// The same in the grid's frame \[cells\].
    #[inline]
    pub fn in_cells(
        frame: &GridFrame,
        start: [f64; 2],
        direction: [f64; 2],
        max_length: f64,
    ) -> Option<Self> {
        let size = [frame.width() as f64, frame.height() as f64];
        let inverse = direction.map(|component| 1.0 / component);
        let (mut enter, mut leave) = (0.0_f64, max_length);
        for axis in 0..2 {
            let (from, to) =
                (-start[axis] * inverse[axis], (size[axis] - start[axis]) * inverse[axis]);
            if direction[axis] == 0.0 {
                if !(start[axis] >= 0.0 && start[axis] < size[axis]) {
                    return None;
                }
            } else {
                enter = enter.max(from.min(to));
                leave = leave.min(from.max(to));
            }
        }
        // Written so that NaN is no ray either.
        let is_ray =
            max_length >= enter && enter <= leave && enter.is_finite() && leave.is_finite();
        let finite = start[0].is_finite() && start[1].is_finite() && direction[0].is_finite();
        (is_ray && finite && direction[1].is_finite()).then_some(GridRay {
            start,
            direction,
            inverse,
            enter,
            leave,
        })
    }

    /// The coordinate along an axis at a length along the ray \[cells\].
    #[inline]
    pub fn at(&self, axis: usize, length: f64) -> f64 {
        self.start[axis] + self.direction[axis] * length
    }

    /// The cell along an axis at a length along the ray, kept within `size` cells.
    #[inline]
    pub(super) fn cell(&self, axis: usize, length: f64, size: usize) -> usize {
        // The cast saturates, below at 0.
        (self.at(axis, length) as usize).min(size - 1)
    }

    /// The length at which the ray enters a cell of an axis, -inf along the other axis.
    #[inline]
    pub(super) fn entry(&self, axis: usize, cell: usize) -> f64 {
        if self.direction[axis] == 0.0 {
            return f64::NEG_INFINITY;
        }
        let edge = if self.direction[axis] < 0.0 { cell + 1 } else { cell };
        (edge as f64 - self.start[axis]) * self.inverse[axis]
    }

    /// The length at which the ray enters a cell that it passes.
    #[inline]
    pub(crate) fn entry_of(&self, cell: [usize; 2]) -> f64 {
        self.entry(0, cell[0]).max(self.entry(1, cell[1])).max(self.enter)
    }

    /// The length at which the ray leaves a cell that it passes.
    #[inline]
    pub fn exit_of(&self, cell: Cell) -> f64 {
        let exit = |axis: usize, cell: usize| match self.direction[axis] {
            0.0 => f64::INFINITY,
            along => {
                let edge = if along < 0.0 { cell } else { cell + 1 };
                (edge as f64 - self.start[axis]) * self.inverse[axis]
            }
        };
        exit(0, cell.column).min(exit(1, cell.row))
    }
}

/// After how many rays of a fan the direction is computed anew instead of rotated further, so
/// that rounding does not add up.
const TURNS: usize = 32;

/// Casts a fan: `cast` is called with the direction of each ray in the grid's frame, a unit
/// vector, and with the place for its range.
#[inline(always)]
pub(super) fn fan(
    frame: &GridFrame,
    first: f64,
    increment: f64,
    ranges: &mut [f64],
    cast: impl Fn([f64; 2]) -> Option<f64>,
) {
    if !(first.is_finite() && increment.is_finite()) {
        return ranges.fill(f64::INFINITY);
    }
    let (sin, cos) = increment.sin_cos();
    for (part, ranges) in ranges.chunks_mut(TURNS).enumerate() {
        let (y, x) = (first + (part * TURNS) as f64 * increment).sin_cos();
        let mut along = frame.turn_to_grid([x, y]);
        for range in ranges {
            *range = cast(along).unwrap_or(f64::INFINITY);
            let [u, v] = along;
            along = [cos * u - sin * v, sin * u + cos * v];
        }
    }
}
