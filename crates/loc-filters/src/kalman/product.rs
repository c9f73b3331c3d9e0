//! Products of small matrices, column by column.
//!
//! The compiler unrolls these loops into vector instructions, since all sizes are constants; at
//! 6 x 6 that is about twice as fast as the general product (bench `kalman`).

use nalgebra::SMatrix;

/// `A B`.
#[inline(always)]
pub(super) fn times<const R: usize, const K: usize, const C: usize>(
    a: &SMatrix<f64, R, K>,
    b: &SMatrix<f64, K, C>,
) -> SMatrix<f64, R, C> {
    let mut out = [[0.0; R]; C];
    for (column, b) in out.iter_mut().zip(&b.data.0) {
        for (a, factor) in a.data.0.iter().zip(b) {
            for (sum, a) in column.iter_mut().zip(a) {
                *sum += a * factor;
            }
        }
    }
    SMatrix::from_data(nalgebra::ArrayStorage(out))
}

/// `A B^T + C`.
#[inline(always)]
pub(super) fn times_transposed<const R: usize, const K: usize, const C: usize>(
    a: &SMatrix<f64, R, K>,
    b: &SMatrix<f64, C, K>,
    c: SMatrix<f64, R, C>,
) -> SMatrix<f64, R, C> {
    let mut out = c.data.0;
    for (j, column) in out.iter_mut().enumerate() {
        for (a, b) in a.data.0.iter().zip(&b.data.0) {
            for (sum, a) in column.iter_mut().zip(a) {
                *sum += a * b[j];
            }
        }
    }
    SMatrix::from_data(nalgebra::ArrayStorage(out))
}

/// A matrix that is symmetric up to rounding, with its lower half mirrored to the upper one.
#[inline(always)]
pub(super) fn mirrored<const N: usize>(mut matrix: SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    for j in 1..N {
        for i in 0..j {
            matrix[(i, j)] = matrix[(j, i)];
        }
    }
    matrix
}
