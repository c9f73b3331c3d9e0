//! Loops over the logarithms of all weights, vectorised.
//!
//! Sums run in eight lanes whatever the machine, so that they are the same everywhere.

use crate::elementary::exp;
use pulp::{Arch, Simd, WithSimd};

/// Numbers looked at side by side.
const LANES: usize = 8;

/// The largest number; -inf without any. NaN is passed over.
#[inline(always)]
pub(crate) fn largest(numbers: &[f64]) -> f64 {
    let larger = |a: f64, b: f64| if b > a { b } else { a };
    let mut lanes = [f64::NEG_INFINITY; LANES];
    let (chunks, rest) = numbers.as_chunks::<LANES>();
    for chunk in chunks {
        for (lane, &number) in lanes.iter_mut().zip(chunk) {
            *lane = larger(*lane, number);
        }
    }
    lanes.iter().chain(rest).copied().fold(f64::NEG_INFINITY, larger)
}

/// Sums of the weights and of their squares, in units of the largest weight.
#[inline(always)]
fn sums(log_weights: &[f64], largest: f64) -> [f64; 2] {
    let (mut sums, mut squares) = ([0.0; LANES], [0.0; LANES]);
    let mut add = |weights: &[f64]| {
        for ((sum, square), weight) in sums.iter_mut().zip(&mut squares).zip(weights) {
            let weight = exp(weight - largest);
            *sum += weight;
            *square += weight * weight;
        }
    };
    let (chunks, rest) = log_weights.as_chunks::<LANES>();
    for chunk in chunks {
        add(chunk);
    }
    add(rest);
    [sums.iter().sum(), squares.iter().sum()]
}

/// Makes the weights add up to 1. The logarithm of their sum before; `None`, and nothing done,
/// where the largest weight is 0 or not finite.
pub(crate) fn normalize(log_weights: &mut [f64]) -> Option<f64> {
    Arch::new().dispatch(Normalize(log_weights))
}

struct Normalize<'a>(&'a mut [f64]);

impl WithSimd for Normalize<'_> {
    type Output = Option<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Option<f64> {
        let largest = largest(self.0);
        if !largest.is_finite() {
            return None;
        }
        let total = largest + sums(self.0, largest)[0].ln();
        for weight in self.0.iter_mut() {
            let normalized = *weight - total;
            // A weight that is no number is none.
            *weight = if normalized < f64::INFINITY { normalized } else { f64::NEG_INFINITY };
        }
        Some(total)
    }
}

/// `(sum w)^2 / sum w^2`: between 1 and the number of weights; 0 where none is above 0.
pub(crate) fn effective_sample_size(log_weights: &[f64]) -> f64 {
    Arch::new().dispatch(EffectiveSampleSize(log_weights))
}

struct EffectiveSampleSize<'a>(&'a [f64]);

impl WithSimd for EffectiveSampleSize<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let largest = largest(self.0);
        if !largest.is_finite() {
            return 0.0;
        }
        let [sum, squares] = sums(self.0, largest);
        sum * sum / squares
    }
}

/// Fills `weights` with the weights, the largest of them 1; all 1 where the largest is 0 or not
/// finite.
pub(crate) fn relative(log_weights: &[f64], weights: &mut Vec<f64>) {
    weights.resize(log_weights.len(), 0.0);
    Arch::new().dispatch(Relative { log_weights, weights });
}

struct Relative<'a> {
    log_weights: &'a [f64],
    weights: &'a mut [f64],
}

impl WithSimd for Relative<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let largest = largest(self.log_weights);
        if !largest.is_finite() {
            return self.weights.fill(1.0);
        }
        for (weight, log_weight) in self.weights.iter_mut().zip(self.log_weights) {
            *weight = exp(log_weight - largest);
        }
    }
}
