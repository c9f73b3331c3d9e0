//! The gain of the smoother, also where a prediction was certain of something.

use crate::Result;
use crate::kalman::factor::Factor;
use loc_core::Error;
use nalgebra::{DMatrix, SMatrix};

/// Directions whose variance is smaller than this share of that of the coordinates, are certain.
const CERTAIN: f64 = 1e-12;

/// `cross P^-1`, where `P` is positive definite; else with its pseudo-inverse.
///
/// What is certain after a prediction cannot be learnt better, so nothing flows back from there.
pub(super) fn gain<const N: usize>(
    cross: &SMatrix<f64, N, N>,
    p: &SMatrix<f64, N, N>,
) -> Result<SMatrix<f64, N, N>> {
    if !p.iter().chain(cross.iter()).all(|value| value.is_finite()) {
        return Err(Error::NotACovariance {
            what: "covariance of a prediction",
            expected: "symmetric positive semi-definite",
            found: format!("{p:?}"),
        }
        .into());
    }
    // In units of the standard deviations, so that metres and radians compare.
    let sigma: [f64; N] = std::array::from_fn(|i| p[(i, i)].max(0.0).sqrt());
    let per_sigma = sigma.map(|sigma| if sigma > 0.0 { 1.0 / sigma } else { 0.0 });
    let correlation = SMatrix::<f64, N, N>::from_fn(|i, j| {
        if i == j { 1.0 } else { p[(i, j)] * per_sigma[i] * per_sigma[j] }
    });
    let scaled = SMatrix::<f64, N, N>::from_fn(|i, j| cross[(i, j)] * per_sigma[j]);
    let solved = match Factor::new(&correlation) {
        Ok(factor) => factor.solve_right(scaled),
        Err(_) => scaled * pseudo_inverse(&correlation),
    };
    Ok(SMatrix::from_fn(|i, j| solved[(i, j)] * per_sigma[j]))
}

/// Inverts a symmetric matrix in the directions in which it is not nearly 0.
fn pseudo_inverse<const N: usize>(matrix: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    let whole = DMatrix::from_fn(N, N, |i, j| 0.5 * (matrix[(i, j)] + matrix[(j, i)]));
    let eigen = whole.symmetric_eigen();
    let inverse = eigen.eigenvalues.map(|value| if value > CERTAIN { 1.0 / value } else { 0.0 });
    let vectors = &eigen.eigenvectors;
    let product = vectors * DMatrix::from_diagonal(&inverse) * vectors.transpose();
    SMatrix::from_fn(|i, j| product[(i, j)])
}
