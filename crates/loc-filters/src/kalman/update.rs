//! The two formulas that every Kalman filter shares, in a form that keeps covariances symmetric
//! and positive.

use crate::Result;
use crate::innovation::{Gate, Innovation};
use loc_core::Gaussian;
use nalgebra::{SMatrix, SVector};

/// `F P F^T + Q`, of which only one half is computed and then mirrored.
#[inline]
pub(crate) fn propagate<const N: usize>(
    f: &SMatrix<f64, N, N>,
    p: &SMatrix<f64, N, N>,
    q: &SMatrix<f64, N, N>,
) -> SMatrix<f64, N, N> {
    congruence(&(f * p), f, q)
}

/// `G B^T + Q` where the result is known to be symmetric.
#[inline]
fn congruence<const N: usize, const M: usize>(
    g: &SMatrix<f64, N, M>,
    b: &SMatrix<f64, N, M>,
    q: &SMatrix<f64, N, N>,
) -> SMatrix<f64, N, N> {
    let mut out = *q;
    for j in 0..N {
        for k in 0..M {
            let factor = b[(j, k)];
            for i in j..N {
                out[(i, j)] += g[(i, k)] * factor;
            }
        }
        for i in j + 1..N {
            out[(j, i)] = out[(i, j)];
        }
    }
    out
}

/// The correction (H1, G2): gain `K = P H^T S^-1`, mean `x + K r`, covariance in Joseph's form
/// `(I - K H) P (I - K H)^T + K R K^T`, a sum of two squares, which rounding cannot make negative.
///
/// The gain is solved from the Cholesky factor of `S = H P H^T + R`; nothing is inverted.
#[inline]
pub(crate) fn correct<const N: usize, const M: usize>(
    belief: &mut Gaussian<N>,
    residual: SVector<f64, M>,
    h: &SMatrix<f64, M, N>,
    r: &SMatrix<f64, M, M>,
    gate: &Gate,
) -> Result<Innovation<M>> {
    let p = &belief.covariance;
    let h_p = h * p;
    let (innovation, factor) = Innovation::new(residual, congruence(&h_p, h, r), gate)?;
    if innovation.accepted {
        let mut gain_transposed = h_p;
        factor.solve_mut(&mut gain_transposed);
        let gain = gain_transposed.transpose();
        let kept = SMatrix::<f64, N, N>::identity() - gain * h;
        let noise = congruence(&(gain * r), &gain, &SMatrix::zeros());
        belief.mean += gain * innovation.residual;
        belief.covariance = congruence(&(kept * p), &kept, &noise);
    }
    Ok(innovation)
}
