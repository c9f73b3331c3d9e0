//! The normal distribution of one number (F3).
//!
//! Most measurement errors gather around 0 in the shape of a bell. The standard deviation says how
//! wide the bell is: of all draws, 0.68 lie within one of it, 0.955 within two, 0.997 within three.
//! For vectors there is [`Gaussian`].
//!
//! ```
//! use loc_core::Normal;
//! let range_error = Normal::new(0.0, 0.03)?;
//! assert!((range_error.probability(-0.03, 0.03) - 0.683).abs() < 1e-3);
//! assert!(range_error.density(0.0) > 1.0, "a density is no probability");
//! # Ok::<(), loc_core::Error>(())
//! ```

use crate::error::{finite, positive, probability};
use crate::{Gaussian, Result};
use nalgebra::{Matrix1, Vector1};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use statrs::function::erf::{erfc, erfc_inv};
use statrs::function::gamma::gamma_ur;
use std::f64::consts::{SQRT_2, TAU};

/// A normal distribution over one number, N(mean, sigma^2) with sigma > 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Normal {
    mean: f64,
    sigma: f64,
}

impl Normal {
    /// The standard normal distribution: mean 0, standard deviation 1.
    pub const STANDARD: Normal = Normal { mean: 0.0, sigma: 1.0 };

    /// A distribution from its mean and its standard deviation `sigma` > 0, both in the unit of
    /// the quantity.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a mean that is not finite, or a `sigma` that is not finite
    /// and above 0.
    pub fn new(mean: f64, sigma: f64) -> Result<Self> {
        Ok(Normal { mean: finite("mean", mean)?, sigma: positive("standard deviation", sigma)? })
    }

    /// The expected value.
    pub fn mean(self) -> f64 {
        self.mean
    }

    /// The standard deviation, in the unit of the quantity.
    pub fn sigma(self) -> f64 {
        self.sigma
    }

    /// The variance `sigma^2`.
    pub fn variance(self) -> f64 {
        self.sigma * self.sigma
    }

    /// Density at `x`, per unit of the quantity. It may exceed 1.
    pub fn density(self, x: f64) -> f64 {
        self.log_density(x).exp()
    }

    /// Natural logarithm of the density at `x`, which does not underflow far from the mean.
    pub fn log_density(self, x: f64) -> f64 {
        let z = self.standardize(x);
        -0.5 * (z * z + TAU.ln()) - self.sigma.ln()
    }

    /// P(X <= x), with full relative accuracy in the lower tail.
    pub fn cdf(self, x: f64) -> f64 {
        lower_tail(self.standardize(x))
    }

    /// P(from <= X <= to); 0 where `from` lies above `to`. Either end may be infinite.
    pub fn probability(self, from: f64, to: f64) -> f64 {
        let (from, to) = (self.standardize(from), self.standardize(to));
        if from > to {
            return 0.0;
        }
        // Above the mean both cumulative values are near 1 and their difference loses its digits;
        // the mirrored interval has the same probability.
        if from > 0.0 {
            lower_tail(-from) - lower_tail(-to)
        } else {
            lower_tail(to) - lower_tail(from)
        }
    }

    /// The value that a share `p` of all draws does not exceed: the inverse of
    /// [`cdf`](Normal::cdf), infinite at 0 and at 1.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a `p` outside \[0, 1\].
    pub fn quantile(self, p: f64) -> Result<f64> {
        let p = probability("share of the draws", p)?;
        Ok(self.mean - self.sigma * SQRT_2 * erfc_inv(2.0 * p))
    }

    /// Draws from the distribution.
    pub fn sample<R: Rng + ?Sized>(self, rng: &mut R) -> f64 {
        let z: f64 = StandardNormal.sample(rng);
        self.mean + self.sigma * z
    }

    /// Distance from the mean in standard deviations.
    fn standardize(self, x: f64) -> f64 {
        (x - self.mean) / self.sigma
    }
}

impl From<Normal> for Gaussian<1> {
    fn from(normal: Normal) -> Self {
        Gaussian { mean: Vector1::new(normal.mean), covariance: Matrix1::new(normal.variance()) }
    }
}

/// P(Z <= z) of the standard normal distribution.
fn lower_tail(z: f64) -> f64 {
    let x = z.abs() / SQRT_2;
    // The error function of statrs 0.19.1 is off by 1e-10 from 0.5 on (its interval constants are
    // cut to ten digits); its incomplete gamma function, the same quantity, is exact.
    let upper = match x {
        _ if x < 0.5 => erfc(x),
        _ if x > UNDERFLOW => 0.0,
        _ => gamma_ur(0.5, x * x),
    };
    if z > 0.0 { 1.0 - 0.5 * upper } else { 0.5 * upper }
}

/// Above this the complementary error function is smaller than any number.
const UNDERFLOW: f64 = 27.3;
