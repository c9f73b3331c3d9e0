//! Normal distributions (F3): [`Gaussian`] over a vector, such as the belief about a pose, and
//! [`Normal`] over one number.
//!
//! ```
//! use loc_core::Gaussian;
//! use nalgebra::{Matrix2, Vector2};
//! let belief = Gaussian::new(Vector2::new(1.0, 2.0), Matrix2::new(4.0, 0.0, 0.0, 1.0))?;
//! let two_sigma = belief.ellipse(2.0);
//! assert_eq!((two_sigma.semi_major, two_sigma.semi_minor), (4.0, 2.0));
//! # Ok::<(), loc_core::Error>(())
//! ```
//!
//! Most measurement errors follow a normal distribution around 0. Of all draws, 0.68 lie within one
//! standard deviation of the mean, 0.955 within two, 0.997 within three.
//!
//! ```
//! use loc_core::Normal;
//! let range_error = Normal::new(0.0, 0.03)?;
//! assert!((range_error.probability(-0.03, 0.03) - 0.683).abs() < 1e-3);
//! assert!(range_error.density(0.0) > 1.0, "a density is no probability");
//! # Ok::<(), loc_core::Error>(())
//! ```

use crate::error::{finite, positive, probability};
use crate::{Error, Result, angle};
use nalgebra::{Cholesky, Const, Matrix1, Matrix2, Matrix3, SMatrix, SVector, Vector1, Vector2};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use statrs::function::erf::{erfc, erfc_inv};
use statrs::function::gamma::gamma_ur;
use std::f64::consts::{SQRT_2, TAU};

/// A normal distribution over `N` numbers, with mean and covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Gaussian<const N: usize> {
    /// The expected value.
    pub mean: SVector<f64, N>,
    /// The covariance: symmetric, positive semi-definite.
    pub covariance: SMatrix<f64, N, N>,
}

/// An ellipse of equal density, k standard deviations from the mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ellipse {
    /// Centre.
    pub center: Vector2<f64>,
    /// Half of the longer axis, in the units of the mean.
    pub semi_major: f64,
    /// Half of the shorter axis.
    pub semi_minor: f64,
    /// Direction of the longer axis, counter-clockwise from x \[rad\].
    pub angle: f64,
}

impl<const N: usize> Gaussian<N> {
    /// A distribution from its mean and covariance.
    ///
    /// A zero covariance (certainty) is allowed.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a mean, [`Error::NotACovariance`] for a covariance that is not
    /// finite, not symmetric, or has a negative eigenvalue.
    pub fn new(mean: SVector<f64, N>, covariance: SMatrix<f64, N, N>) -> Result<Self> {
        for &value in mean.iter() {
            crate::error::finite("mean", value)?;
        }
        check_covariance("covariance", &covariance)?;
        Ok(Gaussian { mean, covariance })
    }

    /// Certainty: the mean with a covariance of zero.
    pub fn certain(mean: SVector<f64, N>) -> Self {
        Gaussian { mean, covariance: SMatrix::zeros() }
    }

    /// Squared Mahalanobis distance of `x`: `(x - mean)^T S^-1 (x - mean)`, which is chi-square
    /// distributed with `N` degrees of freedom.
    ///
    /// # Errors
    /// [`Error::NotACovariance`] where the covariance is singular.
    pub fn mahalanobis_squared(&self, x: &SVector<f64, N>) -> Result<f64> {
        self.deviation_squared(&(x - self.mean))
    }

    /// The same for a deviation that the caller has formed, with its angles wrapped.
    ///
    /// # Errors
    /// [`Error::NotACovariance`] where the covariance is singular.
    pub fn deviation_squared(&self, deviation: &SVector<f64, N>) -> Result<f64> {
        let whitened = cholesky("covariance", &self.covariance)?
            .l_dirty()
            .solve_lower_triangular(deviation)
            .ok_or_else(|| not_definite("covariance", &self.covariance))?;
        Ok(whitened.norm_squared())
    }

    /// Natural logarithm of the density at `x`.
    ///
    /// # Errors
    /// [`Error::NotACovariance`] where the covariance is singular and has no density.
    pub fn log_density(&self, x: &SVector<f64, N>) -> Result<f64> {
        let factor = cholesky("covariance", &self.covariance)?;
        let log_det: f64 = factor.l_dirty().diagonal().iter().map(|d| 2.0 * d.ln()).sum();
        Ok(-0.5 * (self.mahalanobis_squared(x)? + log_det + N as f64 * TAU.ln()))
    }

    /// Draws from the distribution. Singular covariances are allowed: the draws do not vary
    /// along directions that are certain.
    pub fn sample<R: Rng + ?Sized>(&self, rng: &mut R) -> SVector<f64, N> {
        let noise = SVector::<f64, N>::from_fn(|_, _| StandardNormal.sample(rng));
        self.mean + self.factor() * noise
    }

    /// The lower triangular L with `L L^T` = covariance, `N` x `N`, which turns independent draws
    /// into draws from this distribution. Directions that are certain have columns of zeros.
    pub fn factor(&self) -> SMatrix<f64, N, N> {
        semidefinite_factor(&self.covariance)
    }
}

impl Gaussian<2> {
    /// The ellipse `sigmas` standard deviations from the mean (39.3 % of the mass lie within 1,
    /// 86.5 % within 2).
    pub fn ellipse(&self, sigmas: f64) -> Ellipse {
        let s: &Matrix2<f64> = &self.covariance;
        let half_trace = 0.5 * (s.m11 + s.m22);
        let radius = f64::hypot(0.5 * (s.m11 - s.m22), s.m12);
        Ellipse {
            center: self.mean,
            semi_major: sigmas * (half_trace + radius).max(0.0).sqrt(),
            semi_minor: sigmas * (half_trace - radius).max(0.0).sqrt(),
            angle: 0.5 * (2.0 * s.m12).atan2(s.m11 - s.m22),
        }
    }
}

impl Gaussian<3> {
    /// The distribution of the position alone, of a belief about (x, y, theta).
    pub fn position(&self) -> Gaussian<2> {
        Gaussian {
            mean: self.mean.fixed_rows::<2>(0).into(),
            covariance: self.covariance.fixed_view::<2, 2>(0, 0).into(),
        }
    }

    /// The mean as a pose, of a belief about (x, y, theta).
    pub fn pose(&self) -> crate::Pose2 {
        crate::Pose2::from_vector(&self.mean)
    }

    /// Deviation of the true `pose` from the mean, its angle wrapped \[m, m, rad\].
    pub fn pose_deviation(&self, pose: crate::Pose2) -> nalgebra::Vector3<f64> {
        let mut deviation = pose.to_vector() - self.mean;
        deviation.z = angle::wrap(deviation.z);
        deviation
    }
}

/// A belief about a pose with independent standard deviations \[m, m, rad\].
pub fn pose_belief(pose: crate::Pose2, sigmas: [f64; 3]) -> Gaussian<3> {
    let variances = SVector::from(sigmas.map(|s| s * s));
    Gaussian { mean: pose.to_vector(), covariance: Matrix3::from_diagonal(&variances) }
}

/// How far rounding may carry a correlation matrix from symmetric and positive semi-definite.
const COVARIANCE_TOLERANCE: f64 = 1e-9;

/// Checks that a matrix is a covariance: finite, symmetric, no negative eigenvalue, each up to
/// rounding.
///
/// # Errors
/// [`Error::NotACovariance`] with the matrix.
pub fn check_covariance<const N: usize>(
    what: &'static str,
    matrix: &SMatrix<f64, N, N>,
) -> Result<()> {
    // Each row is judged at the scale of its own variance, so that a wrong variance in rad^2 does
    // not hide behind a large one in m^2. Below the floor a variance is 0 up to rounding.
    let largest = matrix.diagonal().amax();
    let floor = 1e-14 * largest + f64::MIN_POSITIVE;
    let scales = matrix.diagonal().map(|variance| variance.max(floor).sqrt());
    let mut shifted = SMatrix::<f64, N, N>::from_fn(|i, j| {
        0.5 * (matrix[(i, j)] + matrix[(j, i)]) / (scales[i] * scales[j])
    });
    shifted.fill_diagonal(1.0 + COVARIANCE_TOLERANCE);
    let asymmetry = SMatrix::<f64, N, N>::from_fn(|i, j| {
        (matrix[(i, j)] - matrix[(j, i)]).abs() / (scales[i] * scales[j])
    });
    let allowed = matrix.iter().all(|value| value.is_finite())
        && matrix.diagonal().iter().all(|&variance| variance >= -floor)
        && asymmetry.amax() <= COVARIANCE_TOLERANCE
        && Cholesky::new(shifted).is_some();
    if allowed { Ok(()) } else { Err(not_semidefinite(what, matrix)) }
}

/// The Cholesky factor of a positive definite matrix.
///
/// # Errors
/// [`Error::NotACovariance`] where it is not positive definite, or not finite.
pub fn cholesky<const N: usize>(
    what: &'static str,
    matrix: &SMatrix<f64, N, N>,
) -> Result<Cholesky<f64, Const<N>>> {
    Cholesky::new(*matrix)
        .filter(|factor| factor.l_dirty().iter().all(|value| value.is_finite()))
        .ok_or_else(|| not_definite(what, matrix))
}

/// A lower triangular L with `L L^T = matrix`, for semi-definite matrices too: a pivot that
/// vanishes leaves its column at zero.
fn semidefinite_factor<const N: usize>(matrix: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    let mut l = SMatrix::<f64, N, N>::zeros();
    for j in 0..N {
        // Rounding is relative to the row's own variance, whatever the units of the others.
        let smallest_pivot = 1e-14 * matrix[(j, j)];
        let pivot = matrix[(j, j)] - (0..j).map(|k| l[(j, k)] * l[(j, k)]).sum::<f64>();
        if pivot <= smallest_pivot {
            continue;
        }
        l[(j, j)] = pivot.sqrt();
        for i in j + 1..N {
            let rest = matrix[(i, j)] - (0..j).map(|k| l[(i, k)] * l[(j, k)]).sum::<f64>();
            l[(i, j)] = rest / l[(j, j)];
        }
    }
    l
}

fn not_definite<const N: usize>(what: &'static str, matrix: &SMatrix<f64, N, N>) -> Error {
    Error::NotACovariance { what, expected: "symmetric positive definite", found: one_line(matrix) }
}

fn not_semidefinite<const N: usize>(what: &'static str, matrix: &SMatrix<f64, N, N>) -> Error {
    Error::NotACovariance {
        what,
        expected: "finite symmetric positive semi-definite",
        found: one_line(matrix),
    }
}

fn one_line<const N: usize>(matrix: &SMatrix<f64, N, N>) -> String {
    let rows: Vec<String> =
        matrix.row_iter().map(|row| format!("{:?}", row.iter().collect::<Vec<_>>())).collect();
    format!("[{}]", rows.join(", "))
}

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
