//! The continuous uniform distribution.

use crate::Result;
use crate::error::{finite, in_range, probability};
use rand::{Rng, RngExt};

/// U\[low, high\]: every number of an interval is equally likely.
///
/// ```
/// use loc_core::probability::Uniform;
/// let temperature = Uniform::new(18.0, 26.0)?;
/// assert!((temperature.probability(20.0, 22.0) - 0.25).abs() < 1e-12);
/// # Ok::<(), loc_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uniform {
    low: f64,
    high: f64,
}

impl Uniform {
    /// The distribution over the interval from `low` to `high`, `low < high`.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for ends that are not finite, in the wrong order, equal, or
    /// so far apart that their distance overflows.
    pub fn new(low: f64, high: f64) -> Result<Self> {
        finite("lower end of the interval", low)?;
        finite("upper end of the interval", high)?;
        let positive = |width: f64| width > 0.0 && width.is_finite();
        in_range("width of the interval", "a finite number > 0", high - low, positive)?;
        Ok(Uniform { low, high })
    }

    /// The lower end.
    pub fn low(self) -> f64 {
        self.low
    }

    /// The upper end.
    pub fn high(self) -> f64 {
        self.high
    }

    /// Density at `x`, per unit of the quantity.
    pub fn density(self, x: f64) -> f64 {
        if x.is_nan() {
            return x;
        }
        if (self.low..=self.high).contains(&x) { 1.0 / self.width() } else { 0.0 }
    }

    /// P(X <= x).
    pub fn cdf(self, x: f64) -> f64 {
        (x.clamp(self.low, self.high) - self.low) / self.width()
    }

    /// P(from <= X <= to); 0 where `from` lies above `to`. Either end may be infinite.
    pub fn probability(self, from: f64, to: f64) -> f64 {
        if from > to {
            return 0.0;
        }
        self.cdf(to) - self.cdf(from)
    }

    /// The value that a share `p` of all draws does not exceed: the inverse of
    /// [`cdf`](Uniform::cdf).
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a `p` outside \[0, 1\].
    pub fn quantile(self, p: f64) -> Result<f64> {
        let p = probability("share of the draws", p)?;
        Ok((self.low + p * self.width()).min(self.high))
    }

    /// The expected value, the middle of the interval.
    pub fn mean(self) -> f64 {
        self.low + 0.5 * self.width()
    }

    /// The variance, `width^2 / 12`.
    pub fn variance(self) -> f64 {
        self.width() * self.width() / 12.0
    }

    /// Draws from the distribution.
    pub fn sample<R: Rng + ?Sized>(self, rng: &mut R) -> f64 {
        (self.low + rng.random::<f64>() * self.width()).min(self.high)
    }

    fn width(self) -> f64 {
        self.high - self.low
    }
}
