//! Which cell over (x, y, theta) a pose falls into.

use super::super::heading::{ROUNDER, wrapped};
use super::super::lanes::is_pose;
use std::f64::consts::TAU;

/// Most headings that are told apart: a square of the floor has one bit for each.
pub(super) const MAX_HEADINGS: u32 = 64;

/// A cell: its square of the floor and the number of its heading.
#[derive(Debug, Clone, Copy)]
pub(super) struct Address {
    /// Row and column of the square, both counted from 2^31 in the middle.
    pub(super) square: [u32; 2],
    pub(super) heading: u32,
}

/// Cuts the space of poses into cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct Raster {
    squares_per_metre: f64,
    headings_per_radian: f64,
    /// Number of headings, at most 64.
    pub(super) headings: u32,
}

impl Raster {
    /// Cells of `side` \[m\] and about `width` \[rad\], so that a whole number of them fills a turn.
    pub(super) fn new(side: f64, width: f64) -> Self {
        let headings = (TAU / width).round().clamp(3.0, f64::from(MAX_HEADINGS));
        Raster {
            squares_per_metre: 1.0 / side,
            headings_per_radian: headings / TAU,
            headings: headings as u32,
        }
    }

    /// Whether three numbers can be a pose.
    #[inline(always)]
    pub(super) fn is_on(x: f64, y: f64, theta: f64) -> bool {
        is_pose(x, y, theta)
    }

    /// The cell of a pose; some cell for what is no pose.
    #[inline(always)]
    pub(super) fn address(&self, x: f64, y: f64, theta: f64) -> Address {
        // Squares more than 2^31 away share numbers with nearer ones, a world away from them.
        let nearest = |metres: f64| {
            let rounded = (metres * self.squares_per_metre + ROUNDER).to_bits() as u32;
            rounded ^ 1 << 31
        };
        let turned = wrapped(theta) * self.headings_per_radian;
        let (truncated, all) = (turned as i32, self.headings as i32);
        let below = truncated - i32::from(f64::from(truncated) > turned);
        let from_zero = if below < 0 { below + all } else { below };
        let heading = if from_zero >= all { from_zero - all } else { from_zero } as u32;
        Address { square: [nearest(y), nearest(x)], heading }
    }
}
