//! The Cholesky factor of an innovation's covariance.

use crate::Result;
use loc_core::Error;
use nalgebra::{SMatrix, SVector};

/// `S = L L^T`, with the diagonal of L kept as its inverse, so that solving only multiplies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Factor<const M: usize> {
    lower: SMatrix<f64, M, M>,
    inverse_diagonal: [f64; M],
    /// Determinant of S.
    pub(crate) determinant: f64,
}

impl<const M: usize> Factor<M> {
    /// Factorises the lower half of `s`.
    ///
    /// # Errors
    /// [`Error::NotACovariance`] where it is not positive definite, or not finite.
    #[inline(always)]
    pub(crate) fn new(s: &SMatrix<f64, M, M>) -> Result<Self> {
        let mut lower = *s;
        let mut inverse_diagonal = [0.0; M];
        let mut determinant = 1.0;
        for j in 0..M {
            for k in 0..j {
                let factor = lower[(j, k)];
                for i in j..M {
                    lower[(i, j)] -= lower[(i, k)] * factor;
                }
            }
            let pivot = lower[(j, j)];
            if !(pivot > 0.0 && pivot.is_finite()) {
                return Err(not_definite(s));
            }
            determinant *= pivot;
            inverse_diagonal[j] = 1.0 / pivot.sqrt();
            for i in j..M {
                lower[(i, j)] *= inverse_diagonal[j];
            }
        }
        Ok(Factor { lower, inverse_diagonal, determinant })
    }

    /// `L^-1 r`.
    #[inline(always)]
    pub(crate) fn whiten(&self, mut r: SVector<f64, M>) -> SVector<f64, M> {
        for j in 0..M {
            for k in 0..j {
                r[j] -= self.lower[(j, k)] * r[k];
            }
            r[j] *= self.inverse_diagonal[j];
        }
        r
    }

    /// `B S^-1`, column by column: first `B L^-T`, then that times `L^-1`.
    #[inline(always)]
    pub(crate) fn solve_right<const N: usize>(&self, b: SMatrix<f64, N, M>) -> SMatrix<f64, N, M> {
        let mut columns = b.data.0;
        for j in 0..M {
            for k in 0..j {
                subtract(&mut columns, j, k, self.lower[(j, k)]);
            }
            columns[j].iter_mut().for_each(|value| *value *= self.inverse_diagonal[j]);
        }
        for j in (0..M).rev() {
            for k in j + 1..M {
                subtract(&mut columns, j, k, self.lower[(k, j)]);
            }
            columns[j].iter_mut().for_each(|value| *value *= self.inverse_diagonal[j]);
        }
        SMatrix::from_data(nalgebra::ArrayStorage(columns))
    }
}

/// Column j minus `factor` times column k.
#[inline(always)]
fn subtract<const N: usize>(columns: &mut [[f64; N]], j: usize, k: usize, factor: f64) {
    let other = columns[k];
    for (value, other) in columns[j].iter_mut().zip(other) {
        *value -= factor * other;
    }
}

#[cold]
fn not_definite<const M: usize>(s: &SMatrix<f64, M, M>) -> crate::Error {
    // The general routine words the refusal.
    match loc_core::gaussian::cholesky("innovation covariance", s) {
        Err(error) => error.into(),
        Ok(_) => Error::OutOfRange {
            what: "smallest pivot of the innovation covariance",
            expected: "a number > 0",
            found: 0.0,
        }
        .into(),
    }
}
