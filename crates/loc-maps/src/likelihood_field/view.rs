//! A pose as the lookups need it.

use crate::grid::GridFrame;
use nalgebra::Point2;
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

/// A pose in the grid's frame, in single precision.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct View {
    /// Column and row \[cells\].
    pub(super) u: f32,
    pub(super) v: f32,
    /// Cosine and sine of the heading \[cells/m\].
    pub(super) cos: f32,
    pub(super) sin: f32,
}

impl View {
    /// The view from a pose of the map \[m, m, rad\].
    #[inline(always)]
    pub(super) fn new(frame: &GridFrame, x: f64, y: f64, theta: f64) -> Self {
        let at = frame.to_cells(&Point2::new(x, y));
        let scale = (1.0 / frame.resolution()) as f32;
        let (sin, cos) = sin_cos(theta - frame.origin().theta);
        View { u: at.x as f32, v: at.y as f32, cos: cos * scale, sin: sin * scale }
    }

    /// The end of a beam \[m\] in the grid's frame \[cells\].
    #[inline(always)]
    pub(super) fn end(self, x: f32, y: f32) -> (f32, f32) {
        let View { u, v, cos, sin } = self;
        (u + cos * x - sin * y, v + sin * x + cos * y)
    }
}

/// Added to a number below 2^51, it leaves the nearest whole number in the lowest bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// Sine and cosine in single precision, off by 1e-7 at most, which turns a beam of 30 m by 3 um.
/// Without branches and calls, so that several angles go through it side by side; and the same on
/// every machine, which the functions of the system's library are not.
///
/// The angle \[rad\], which may have many turns (up to 1e9), is reduced to +-pi/4 in double
/// precision; polynomials of the Cephes library (S. L. Moshier) do the rest. Angles that are not
/// finite yield NaN.
#[inline(always)]
pub(super) fn sin_cos(angle: f64) -> (f32, f32) {
    let quarters = angle * FRAC_2_PI + ROUND;
    let quarter = quarters.to_bits() as u32;
    let rest = (angle - (quarters - ROUND) * FRAC_PI_2) as f32;
    let square = rest * rest;
    let sin = ((-1.951_529_6e-4 * square + 8.332_161e-3) * square - 1.666_665_5e-1) * square;
    let sin = sin * rest + rest;
    let cos = (2.443_315_7e-5 * square - 1.388_731_6e-3) * square + 4.166_664_6e-2;
    let cos = cos * square * square - 0.5 * square + 1.0;
    let (sin, cos) = if quarter & 1 == 0 { (sin, cos) } else { (cos, sin) };
    // The second bit of the quarter, moved to where a number keeps its sign.
    let flip = |value: f32, bits: u32| f32::from_bits(value.to_bits() ^ ((bits & 2) << 30));
    (flip(sin, quarter), flip(cos, quarter.wrapping_add(1)))
}
