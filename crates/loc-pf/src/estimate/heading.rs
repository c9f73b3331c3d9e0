//! Sines and cosines of many headings: without branches and calls, so that several are worked out
//! by one instruction.

use std::f64::consts::{FRAC_2_PI, TAU};

/// Added to a number and taken off again, it leaves the nearest whole number, whose last bits are
/// those of the sum.
pub(super) const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// A quarter turn in two parts, of which the first has few digits: its multiples are exact.
const QUARTER: [f64; 2] = [1.570_796_326_734_125_6, 6.077_100_506_506_192e-11];

/// Sine and cosine of a heading \[rad\], within 2e-15 for headings of a few turns.
#[inline(always)]
pub(super) fn sin_cos(theta: f64) -> (f64, f64) {
    let rounded = theta * FRAC_2_PI + ROUNDER;
    let (quarters, count) = (rounded.to_bits(), rounded - ROUNDER);
    let rest = theta - count * QUARTER[0] - count * QUARTER[1];
    // Both series end below the last digit, as the rest is at most an eighth of a turn.
    let z = rest * rest;
    let sin = rest * series(z, [3.0, 5.0, 7.0, 9.0, 11.0, 13.0, 15.0]);
    let cos = series(z, [2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0]);
    let odd = 0_u64.wrapping_sub(quarters & 1);
    let (s, c) = (sin.to_bits(), cos.to_bits());
    let swap = (s ^ c) & odd;
    let sign = |bits: u64| (bits & 2) << 62;
    let sin = f64::from_bits((s ^ swap) ^ sign(quarters));
    let cos = f64::from_bits((c ^ swap) ^ sign(quarters.wrapping_add(1)));
    (sin, cos)
}

/// `1 - z / (k0 (k0 - 1)) (1 - z / (k1 (k1 - 1)) (..))`: the series of sine over x or cosine.
#[inline(always)]
fn series(z: f64, orders: [f64; 7]) -> f64 {
    orders.iter().rev().fold(1.0, |tail, k| 1.0 - z * (1.0 / (k * (k - 1.0))) * tail)
}

/// An angle without its whole turns \[rad\], in \[-pi, pi\].
#[inline(always)]
pub(super) fn wrapped(angle: f64) -> f64 {
    angle - TAU * ((angle * (1.0 / TAU) + ROUNDER) - ROUNDER)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_and_turns_are_those_of_the_standard_library() {
        for k in -20_000..=20_000 {
            let theta = f64::from(k) * 0.001;
            let (sin, cos) = sin_cos(theta);
            assert!((sin - theta.sin()).abs() < 2e-15 && (cos - theta.cos()).abs() < 2e-15);
            assert!((wrapped(theta) - loc_core::angle::wrap(theta)).abs() < 1e-14);
        }
    }
}
