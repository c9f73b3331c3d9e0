//! Elementary functions in single precision, without branches and calls, so that a loop over many
//! particles becomes vector instructions.
//!
//! No fused multiply-add is asked for: the results are the same on every processor.

use std::f32::consts::{FRAC_2_PI, FRAC_PI_2, LN_2, LOG2_E, PI, SQRT_2};

/// Adding and subtracting 1.5 * 2^23 rounds to the nearest whole number, which then also stands in
/// the lowest bits.
const ROUND: f32 = 12_582_912.0;

/// Sine and cosine of an angle of at most a few turns \[rad\], to 2e-7.
#[inline(always)]
pub(super) fn sin_cos(angle: f32) -> (f32, f32) {
    let shifted = angle * FRAC_2_PI + ROUND;
    let (quarter, turns) = (shifted.to_bits(), shifted - ROUND);
    // pi / 2 in two parts, the first of few digits, so that the product is exact.
    let r = (angle - turns * 1.570_312_5) - turns * 4.838_268e-4;
    let r2 = r * r;
    let sin = r + r * r2 * (-0.166_666_55 + r2 * (8.332_161e-3 - r2 * 1.951_529_6e-4));
    let cos =
        1.0 - 0.5 * r2 + r2 * r2 * (4.166_664_6e-2 + r2 * (-1.388_731_6e-3 + r2 * 2.443_315_7e-5));
    let odd = quarter & 1 != 0;
    let (s, c) = if odd { (cos, sin) } else { (sin, cos) };
    let signed = |value: f32, sign: u32| f32::from_bits(value.to_bits() ^ ((sign & 2) << 30));
    (signed(s, quarter), signed(c, quarter.wrapping_add(1)))
}

/// The unsigned angle between a direction and another whose components along and across it are
/// given, in \[0, pi\] \[rad\], to 4e-6 and, near the direction, a relative 5e-6; 0 where both
/// vanish.
#[inline(always)]
pub(super) fn angle(along: f32, across: f32) -> f32 {
    let (a, b) = (along.abs(), across.abs());
    let (small, large) = if a < b { (a, b) } else { (b, a) };
    let t = small / if large > f32::MIN_POSITIVE { large } else { f32::MIN_POSITIVE };
    let t2 = t * t;
    let upper = -0.121_239_066 + t2 * (0.057_477_307 - t2 * 0.013_480_466);
    let tail = 0.999_995_65 + t2 * (-0.332_994_6 + t2 * (0.195_635_92 + t2 * upper));
    let eighth = t * tail;
    let quarter = if a < b { FRAC_PI_2 - eighth } else { eighth };
    if along < 0.0 { PI - quarter } else { quarter }
}

/// Below this the exponential counts as that of it, 1.6e-38.
const LOWEST: f32 = -87.0;

/// The exponential of a number of at most 0, to a relative 3e-6.
#[inline(always)]
pub(super) fn exp(x: f32) -> f32 {
    let x = if x > LOWEST { x } else { LOWEST };
    let shifted = x * LOG2_E + ROUND;
    let (bits, twos) = (shifted.to_bits(), shifted - ROUND);
    // ln 2 in two parts, as above.
    let r = (x - twos * 0.693_359_4) + twos * 2.121_944_4e-4;
    let upper = 0.500_043_6 + r * (0.167_909_07 + r * 0.041_458_607);
    let series = 0.999_999_3 + r * (0.999_963_4 + r * upper);
    let power = f32::from_bits(bits.wrapping_sub(ROUND.to_bits()).wrapping_add(127) << 23);
    series * power
}

/// The natural logarithm of a positive number that is not subnormal, to 2e-7 and a relative 2e-7.
#[inline(always)]
pub(super) fn ln(x: f32) -> f32 {
    // The mantissa in [sqrt(1/2), sqrt(2)), by way of moving where the exponent steps.
    let offset = x.to_bits().wrapping_sub((0.5 * SQRT_2).to_bits());
    let exponent = (offset as i32) >> 23;
    let mantissa = f32::from_bits(x.to_bits().wrapping_sub((exponent as u32) << 23));
    let (e, m) = (exponent as f32, mantissa - 1.0);
    let m2 = m * m;
    let upper = -0.124_201_41 + m * (0.116_769_99 + m * (-0.115_146_1 + m * 0.070_376_836));
    let middle = -0.166_680_58 + m * (0.142_493_23 + m * upper);
    let tail = 0.333_333_3 + m * (-0.249_999_94 + m * (0.200_007_15 + m * middle));
    m - 0.5 * m2 + m * m2 * tail + e * LN_2
}
