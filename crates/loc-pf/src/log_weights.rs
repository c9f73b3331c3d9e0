//! Loops over the logarithms of all weights, vectorised.
//!
//! Sums run in eight lanes whatever the machine, and over parts of a fixed size whatever the number
//! of threads, so that they are the same everywhere.

use crate::elementary::exp;
use crate::workers::{PART, Workers};
use pulp::{Arch, Simd, WithSimd};

/// Numbers processed side by side.
const LANES: usize = 8;

/// The largest number; -inf without any. NaN is ignored.
#[inline(always)]
fn largest(numbers: &[f64]) -> f64 {
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

/// The largest number of all; as [`largest`].
pub(crate) fn largest_of_all(workers: &Workers, numbers: &[f64]) -> f64 {
    let of_part = |part| Arch::new().dispatch(FindLargest(part));
    largest(&workers.map(numbers.chunks(PART), of_part))
}

struct FindLargest<'a>(&'a [f64]);

impl WithSimd for FindLargest<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        largest(self.0)
    }
}

/// A sum of weights, in units of the largest of them, so that nothing underflows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mass {
    /// Logarithm of the largest weight; -inf without any.
    largest: f64,
    sum: f64,
    squares: f64,
}

impl Default for Mass {
    /// No weights at all.
    fn default() -> Self {
        Mass { largest: f64::NEG_INFINITY, sum: 0.0, squares: 0.0 }
    }
}

impl Mass {
    /// The weights of a part of the particles.
    pub(crate) fn of(log_weights: &[f64]) -> Mass {
        Arch::new().dispatch(AddUp(log_weights))
    }

    /// The weights of a part after a share of a measurement, whose log-likelihoods are given;
    /// they go to `after`.
    pub(crate) fn after(
        log_weights: &[f64],
        share: f64,
        log_likelihoods: &[f64],
        after: &mut [f64],
    ) -> Mass {
        Arch::new().dispatch(TakeIn { log_weights, share, log_likelihoods, after })
    }

    /// The weights of all particles: parts added up in their order.
    pub(crate) fn total(parts: impl IntoIterator<Item = Mass>) -> Mass {
        parts.into_iter().fold(Mass::default(), Mass::plus)
    }

    fn plus(self, other: Mass) -> Mass {
        let largest = if other.largest > self.largest { other.largest } else { self.largest };
        if !largest.is_finite() {
            return Mass { largest, ..Mass::default() };
        }
        let [a, b] = [self, other].map(|mass| exp(mass.largest - largest));
        let sum = a * self.sum + b * other.sum;
        let squares = a * a * self.squares + b * b * other.squares;
        Mass { largest, sum, squares }
    }

    /// The logarithm of the sum; `None` where the largest weight is 0 or not finite.
    pub(crate) fn log_sum(&self) -> Option<f64> {
        self.largest.is_finite().then(|| self.largest + self.sum.ln())
    }

    /// `(sum w)^2 / sum w^2`: between 1 and the number of weights; 0 where the largest weight is 0
    /// or not finite.
    pub(crate) fn effective_sample_size(&self) -> f64 {
        if self.largest.is_finite() { self.sum * self.sum / self.squares } else { 0.0 }
    }
}

struct AddUp<'a>(&'a [f64]);

impl WithSimd for AddUp<'_> {
    type Output = Mass;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Mass {
        add_up(self.0)
    }
}

#[inline(always)]
fn add_up(log_weights: &[f64]) -> Mass {
    let largest = largest(log_weights);
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
    Mass { largest, sum: sums.iter().sum(), squares: squares.iter().sum() }
}

/// Weights by a share of a measurement.
struct TakeIn<'a> {
    log_weights: &'a [f64],
    share: f64,
    log_likelihoods: &'a [f64],
    after: &'a mut [f64],
}

impl WithSimd for TakeIn<'_> {
    type Output = Mass;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Mass {
        let before = self.log_weights.iter().zip(self.log_likelihoods);
        for (after, (weight, likelihood)) in self.after.iter_mut().zip(before) {
            *after = weight + self.share * likelihood;
        }
        add_up(self.after)
    }
}

/// Divides all weights by one whose logarithm is given. A weight that is no number becomes 0.
pub(crate) fn divide(log_weights: &mut [f64], by: f64) {
    Arch::new().dispatch(Divide { log_weights, by });
}

struct Divide<'a> {
    log_weights: &'a mut [f64],
    by: f64,
}

impl WithSimd for Divide<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for weight in self.log_weights {
            let divided = *weight - self.by;
            *weight = if divided < f64::INFINITY { divided } else { f64::NEG_INFINITY };
        }
    }
}

/// Fills `weights` with the weights, the largest of them 1; all 1 where the largest is 0 or not
/// finite.
pub(crate) fn relative(workers: &Workers, log_weights: &[f64], weights: &mut Vec<f64>) {
    weights.resize(log_weights.len(), 0.0);
    let largest = largest_of_all(workers, log_weights);
    let parts = log_weights.chunks(PART).zip(weights.chunks_mut(PART));
    workers.for_each(parts, |(log_weights, weights)| {
        Arch::new().dispatch(Relative { log_weights, weights, largest });
    });
}

struct Relative<'a> {
    log_weights: &'a [f64],
    weights: &'a mut [f64],
    largest: f64,
}

impl WithSimd for Relative<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        if !self.largest.is_finite() {
            return self.weights.fill(1.0);
        }
        for (weight, log_weight) in self.weights.iter_mut().zip(self.log_weights) {
            *weight = exp(log_weight - self.largest);
        }
    }
}
