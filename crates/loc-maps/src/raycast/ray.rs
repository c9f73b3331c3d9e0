//! A ray in the frame of a grid, cut to the part that lies on it.

use crate::grid::{Cell, GridFrame};
use nalgebra::Point2;

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

/// After how many rays of a fan the direction is computed anew instead of turned on, so that
/// rounding does not add up.
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
