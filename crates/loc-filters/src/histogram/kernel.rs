//! How the probability of one cell spreads over its neighbours when the robot moves.
//!
//! The robot may be anywhere in its cell, evenly. It moves by a shift that need not be a whole
//! number of cells, and by a normal error on top. Which share of the cell's probability ends up in
//! the cell k steps away? The answer has a closed form, and the shares of all k add up to 1: no
//! probability is made or lost, however coarse the cells. Without an error and for a shift by whole
//! cells everything moves as it is.
//!
//! ```
//! use loc_filters::histogram::Kernel;
//! assert_eq!(Kernel::new(2.0, 0.0)?.weights(), [1.0]);
//! assert_eq!(Kernel::new(0.25, 0.0)?.weights(), [0.75, 0.25]);
//! let blurred = Kernel::new(0.25, 1.0)?;
//! assert!((blurred.weights().iter().sum::<f64>() - 1.0).abs() < 1e-12);
//! # Ok::<(), loc_filters::Error>(())
//! ```

use crate::Result;
use loc_core::Normal;
use loc_core::error::{finite, in_range, non_negative};

/// Errors beyond so many standard deviations are left out: one in two million.
const TAIL: f64 = 5.0;

/// The largest shift and the largest error that a kernel may have \[cells\].
const LARGEST: f64 = 1e6;

/// Weights below this share are rounding.
const ROUNDING: f64 = 1e-15;

/// The shares of a cell's probability that go to its neighbours in one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Kernel {
    first: isize,
    weights: Vec<f64>,
}

impl Kernel {
    /// The kernel of a motion by `shift` with a normal error of standard deviation `sigma`, both in
    /// cells.
    ///
    /// With `G(t) = t Phi(t / sigma) + sigma phi(t / sigma)`, the second integral of the density,
    /// the share of the cell `k` steps away is `G(u + 1) - 2 G(u) + G(u - 1)`, `u = k - shift`: the
    /// probability that a point of the cell, evenly drawn, ends there. Errors beyond five standard
    /// deviations are left out and their share is given to the others.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for numbers that are not finite or beyond 1e6, and for a
    /// negative `sigma`.
    pub fn new(shift: f64, sigma: f64) -> Result<Self> {
        Kernel::check(shift, sigma)?;
        Ok(Kernel::cut_off(shift, sigma, TAIL))
    }

    /// Whether a kernel can be had.
    pub(super) fn check(shift: f64, sigma: f64) -> Result<()> {
        let small = |value: f64| value.abs() <= LARGEST;
        finite("shift [cells]", shift)?;
        in_range("shift [cells]", "at most 1e6", shift, small)?;
        non_negative("standard deviation of a motion [cells]", sigma)?;
        in_range("standard deviation of a motion [cells]", "at most 1e6", sigma, small)?;
        Ok(())
    }

    /// The same for numbers that are known to be sound, with errors up to `tail` standard
    /// deviations.
    pub(super) fn cut_off(shift: f64, sigma: f64, tail: f64) -> Self {
        let reach = 1.0 + tail * sigma;
        let (first, last) = ((shift - reach).floor() as isize, (shift + reach).ceil() as isize);
        let integral = second_integral(sigma);
        let at = |k: isize| integral(k as f64 - shift);
        let (mut before, mut here) = (at(first - 1), at(first));
        let share = |k: isize| {
            let after = at(k + 1);
            let share = after - 2.0 * here + before;
            (before, here) = (here, after);
            if share > ROUNDING { share } else { 0.0 }
        };
        Kernel::trimmed(first, (first..=last).map(share).collect())
    }

    /// Leaves out zeros at both ends and scales the rest to the sum 1.
    fn trimmed(first: isize, mut weights: Vec<f64>) -> Self {
        let leading = weights.iter().take_while(|weight| **weight <= 0.0).count();
        weights.drain(..leading);
        let used = weights.iter().rposition(|weight| *weight > 0.0).map_or(0, |last| last + 1);
        weights.truncate(used);
        let sum: f64 = weights.iter().sum();
        // A whole number of cells must stay exactly that.
        if weights.len() > 1 {
            weights.iter_mut().for_each(|weight| *weight /= sum);
        } else {
            weights.fill(1.0);
        }
        Kernel { first: first + leading as isize, weights }
    }

    /// How many cells away the first weight leads; negative for backwards.
    pub fn first(&self) -> isize {
        self.first
    }

    /// The shares, of one cell after the other; their sum is 1.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Pairs (cells away, share).
    pub fn iter(&self) -> impl Iterator<Item = (isize, f64)> + '_ {
        (self.first..).zip(self.weights.iter().copied())
    }

    /// Adds what comes of the probabilities `from` to `to`. Cell k of `from` has the place
    /// `k + offset` of `to`; what would end up outside of `to` is left out.
    pub(super) fn spread(&self, from: &[f64], to: &mut [f64], offset: isize) {
        for (away, weight) in self.iter() {
            let start = away + offset;
            let (skip, place) =
                if start < 0 { (start.unsigned_abs(), 0) } else { (0, start.unsigned_abs()) };
            let sources = from.get(skip..).unwrap_or_default();
            let targets = to.get_mut(place..).unwrap_or_default();
            for (target, source) in targets.iter_mut().zip(sources) {
                *target += weight * source;
            }
        }
    }
}

/// The second integral of the normal density with this standard deviation.
fn second_integral(sigma: f64) -> impl Fn(f64) -> f64 {
    move |t: f64| {
        if sigma <= 0.0 {
            return t.max(0.0);
        }
        let z = t / sigma;
        t * Normal::STANDARD.cdf(z) + sigma * Normal::STANDARD.density(z)
    }
}
