//! The two formulas that every Kalman filter shares, in a form that keeps covariances symmetric
//! and positive.

use super::product::{mirrored, times, times_transposed};
use crate::Result;
use crate::innovation::{Gate, Innovation};
use loc_core::Gaussian;
use nalgebra::{SMatrix, SVector};

/// `F P F^T + Q`, exactly symmetric.
#[inline]
pub(crate) fn propagate<const N: usize>(
    f: &SMatrix<f64, N, N>,
    p: &SMatrix<f64, N, N>,
    q: &SMatrix<f64, N, N>,
) -> SMatrix<f64, N, N> {
    mirrored(times_transposed(&times(f, p), f, *q))
}

/// The correction (H1, G2): gain `K = P H^T S^-1`, mean `x + K r`, covariance in Joseph's form
/// `(I - K H) P (I - K H)^T + K R K^T`, a sum of two squares, which rounding cannot make negative.
///
/// The gain is solved from the Cholesky factor of `S = H P H^T + R`; nothing is inverted.
#[inline]
// ANCHOR: correct
pub(crate) fn correct<const N: usize, const M: usize>(
    belief: &mut Gaussian<N>,
    residual: SVector<f64, M>,
    h: &SMatrix<f64, M, N>,
    r: &SMatrix<f64, M, M>,
    gate: &Gate,
) -> Result<Innovation<M>> {
    let p = &belief.covariance;
    let p_ht = times_transposed(p, h, SMatrix::zeros());
    let s = mirrored(times(h, &p_ht) + r);
    let (innovation, factor) = Innovation::new(residual, s, gate)?;
    if innovation.accepted {
        let gain = factor.solve_right(p_ht);
        let kept = SMatrix::<f64, N, N>::identity() - times(&gain, h);
        // (I - K H) P, with the product H P that is known already.
        let kept_p = times_transposed(&-gain, &p_ht, *p);
        let noise = times_transposed(&times(&gain, r), &gain, SMatrix::zeros());
        belief.mean += gain * innovation.residual;
        belief.covariance = mirrored(times_transposed(&kept_p, &kept, noise));
    }
    Ok(innovation)
}
// ANCHOR_END: correct
