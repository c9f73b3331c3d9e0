//! Exponential, logarithm, sine and cosine written without branches, so that a loop over many
//! numbers becomes vector code.
//!
//! The library's functions are exact to the last bit and take one number at a time; these are
//! exact to the figures given with each and take four or eight. They consist of sums, products and
//! bit patterns alone, which every processor rounds the same way: the results do not depend on the
//! vector instructions that the machine has.

use std::f64::consts::{FRAC_2_PI, LN_2, LOG2_E, PI, TAU};

/// Added to a number between -2^51 and 2^51 it leaves the nearest integer in the lowest bits.
pub(crate) const ROUND: f64 = 1.5 * (1_u64 << 52) as f64;

/// The first 33 bits of pi/2, whose products with small integers are exact, and the rest.
const HALF_PI: [f64; 2] = [1.570_796_326_734_125_6, 6.077_100_506_506_192e-11];

/// The first bits of ln 2, and the rest.
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// Below this an exponential is taken for 0.
const UNDERFLOW: f64 = -708.0;

/// `c[0] + c[1] x + ..`.
#[inline(always)]
fn polynomial<const N: usize>(c: [f64; N], x: f64) -> f64 {
    c.iter().rev().fold(0.0, |sum, &c| sum * x + c)
}

/// The exponential of a number <= 0, to 2e-15 of its value; 0 below -708 and for NaN.
#[inline(always)]
pub(crate) fn exp(x: f64) -> f64 {
    let bounded = if x > UNDERFLOW { x } else { UNDERFLOW };
    let shifted = bounded * LOG2_E + ROUND;
    let n = shifted - ROUND;
    let r = (bounded - n * LN_2_HIGH) - n * LN_2_LOW;
    // |r| <= ln 2 / 2; the first term left out is below 7e-15.
    const TAYLOR: [f64; 12] = reciprocal_factorials([0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]);
    let power = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    let value = polynomial(TAYLOR, r) * power;
    if x > UNDERFLOW { value } else { 0.0 }
}

/// Sine and cosine, to 3e-14 for angles below 1e5 rad; beyond, the error grows with the angle, and
/// for NaN and infinity the result is some number.
#[inline(always)]
pub(crate) fn sin_cos(x: f64) -> (f64, f64) {
    let shifted = x * FRAC_2_PI + ROUND;
    let n = shifted - ROUND;
    let r = (x - n * HALF_PI[0]) - n * HALF_PI[1];
    // Rounding carries an angle of any size no further than this from its quarter turn.
    let r = if r < 0.8 { r } else { 0.8 };
    let r = if r > -0.8 { r } else { -0.8 };
    const SIN: [f64; 7] = alternating(reciprocal_factorials([1, 3, 5, 7, 9, 11, 13]));
    const COS: [f64; 8] = alternating(reciprocal_factorials([0, 2, 4, 6, 8, 10, 12, 14]));
    let square = r * r;
    let sin = (r * polynomial(SIN, square)).to_bits();
    let cos = polynomial(COS, square).to_bits();
    // Quarter turns exchange sine and cosine and change their signs.
    let quarters = shifted.to_bits();
    let exchange = (sin ^ cos) & 0_u64.wrapping_sub(quarters & 1);
    let sin = sin ^ exchange ^ ((quarters & 2) << 62);
    let cos = cos ^ exchange ^ ((quarters.wrapping_add(1) & 2) << 62);
    (f64::from_bits(sin), f64::from_bits(cos))
}

/// The representative of an angle in (-pi, pi]; exact where one turn leads there.
#[inline(always)]
pub(crate) fn wrap(angle: f64) -> f64 {
    let turns = (angle * (1.0 / TAU) + ROUND) - ROUND;
    let rest = angle - turns * TAU;
    let rest = if rest > PI { rest - TAU } else { rest };
    let rest = if rest <= -PI { rest + TAU } else { rest };
    // Beyond 1e15 rad an angle has no digits left for a direction.
    if rest > -PI && rest <= PI { rest } else { 0.0 }
}

/// The natural logarithm of a normal positive number, to 2e-7 of its value.
#[inline(always)]
pub(crate) fn ln_f32(x: f32) -> f32 {
    /// The bits of sqrt(1/2).
    const LOWEST: u32 = 0x3f35_04f3;
    let exponent = (x.to_bits().wrapping_sub(LOWEST) as i32) >> 23;
    let mantissa = f32::from_bits(x.to_bits().wrapping_sub((exponent << 23) as u32));
    // ln m = 2 artanh((m - 1) / (m + 1)), for m in [sqrt(1/2), sqrt(2)).
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let t = s * s;
    let series = 2.0 + t * (2.0 / 3.0 + t * (2.0 / 5.0 + t * (2.0 / 7.0 + t * (2.0 / 9.0))));
    exponent as f32 * LN_2 as f32 + s * series
}

/// Sine and cosine of an angle in \[-pi/4, pi/4\], to 1e-7.
#[inline(always)]
pub(crate) fn sin_cos_octant_f32(x: f32) -> (f32, f32) {
    let t = x * x;
    let sin = x * (1.0 - t * (1.0 / 6.0 - t * (1.0 / 120.0 - t * (1.0 / 5040.0 - t / 362_880.0))));
    let cos = 1.0 - t * (0.5 - t * (1.0 / 24.0 - t * (1.0 / 720.0 - t * (1.0 / 40320.0))));
    (sin, cos)
}

const fn reciprocal_factorials<const N: usize>(n: [u32; N]) -> [f64; N] {
    let mut terms = [1.0; N];
    let mut i = 0;
    while i < N {
        let mut factor = n[i];
        while factor > 1 {
            terms[i] /= factor as f64;
            factor -= 1;
        }
        i += 1;
    }
    terms
}

const fn alternating<const N: usize>(mut terms: [f64; N]) -> [f64; N] {
    let mut i = 1;
    while i < N {
        terms[i] = -terms[i];
        i += 2;
    }
    terms
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(from: f64, to: f64) -> impl Iterator<Item = f64> {
        (0..=20_000).map(move |k| from + (to - from) * f64::from(k) / 20_000.0)
    }

    #[test]
    fn functions_are_as_exact_as_they_say() {
        for x in steps(-700.0, 0.0).chain(steps(-1.0, 0.0)) {
            assert!((exp(x) / x.exp() - 1.0).abs() < 2e-14, "exp {x}");
        }
        for x in steps(-1e5, 1e5).chain(steps(-7.0, 7.0)) {
            let ((sin, cos), exact) = (sin_cos(x), x.sin_cos());
            assert!((sin - exact.0).abs() < 3e-14 && (cos - exact.1).abs() < 3e-14, "sin_cos {x}");
            let direction = loc_core::angle::wrap(x);
            assert!((wrap(x) - direction).abs() < 1e-10, "wrap {x}");
        }
        for x in steps(-33.0, 0.0).chain(steps(-1e-4, -1e-6)) {
            let x = 2_f64.powf(x) as f32;
            let exact = f64::from(x).ln();
            assert!((f64::from(ln_f32(x)) - exact).abs() <= 2e-7 * exact.abs(), "ln {x}");
        }
        for x in steps(-PI / 4.0, PI / 4.0) {
            let (sin, cos) = sin_cos_octant_f32(x as f32);
            assert!((f64::from(sin) - x.sin()).abs() < 1e-7, "sin {x}");
            assert!((f64::from(cos) - x.cos()).abs() < 1e-7, "cos {x}");
        }
    }

    #[test]
    fn odd_arguments_have_defined_results() {
        for x in [f64::NAN, f64::NEG_INFINITY, -709.0, -1e300] {
            assert_eq!(exp(x).to_bits(), 0, "exp {x}");
        }
        assert_eq!(exp(0.0).to_bits(), 1_f64.to_bits());
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e18, 3e9] {
            let (sin, cos) = sin_cos(x);
            assert!(sin.abs() <= 1.0 && cos.abs() <= 1.0, "sin_cos {x}");
            assert!(wrap(x) > -PI && wrap(x) <= PI, "wrap {x}");
        }
        assert_eq!(wrap(PI).to_bits(), PI.to_bits());
        assert_eq!(wrap(-PI).to_bits(), PI.to_bits());
        assert_eq!(wrap(-0.0).to_bits(), (-0.0_f64).to_bits());
    }
}
