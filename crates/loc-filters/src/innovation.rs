//! The innovation of a measurement, and the gate that accepts or rejects it.
//!
//! The innovation is the difference between a measurement and what the filter expected. Its
//! normalised square, the NIS, says whether the measurement fits: it is chi-square distributed for a
//! consistent filter. A [`Gate`] rejects measurements whose NIS is too large.
//!
//! ```
//! use loc_filters::Gate;
//! let gate = Gate::probability(0.95)?;
//! assert!((gate.threshold(2) - 5.9915).abs() < 1e-4);
//! # Ok::<(), loc_filters::Error>(())
//! ```

use crate::{Error, Result};
use loc_core::stats::chi_square_quantile;
use nalgebra::{SMatrix, SVector};

/// Residual of one measurement, with the numbers that the gate has tested.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Innovation<const M: usize> {
    /// Measurement minus expectation, angles wrapped; also known as the prefit residual.
    pub residual: SVector<f64, M>,
    /// Its covariance, `S = H P H^T + R`.
    pub covariance: SMatrix<f64, M, M>,
    /// Its determinant, which the likelihood needs.
    pub determinant: f64,
    /// `L^-1 residual` with `L L^T = S`: independent, with unit variance.
    pub whitened: SVector<f64, M>,
    /// Normalised innovation squared, `residual^T S^-1 residual`.
    pub nis: f64,
    /// The threshold of the gate: the largest NIS that is accepted.
    pub threshold: f64,
    /// Whether it was accepted; a rejected one has left the filter as it was.
    pub accepted: bool,
}

impl<const M: usize> Innovation<M> {
    /// Tests a residual against its covariance; also returns the Cholesky factor of the latter.
    #[inline(always)]
    pub(crate) fn new(
        residual: SVector<f64, M>,
        covariance: SMatrix<f64, M, M>,
        gate: &Gate,
    ) -> Result<(Self, Factor<M>)> {
        let factor = Factor::new(&covariance)?;
        let determinant = factor.determinant;
        let whitened = factor.whiten(residual);
        let nis = whitened.norm_squared();
        let threshold = gate.threshold(M);
        let accepted = nis <= threshold;
        let innovation =
            Innovation { residual, covariance, determinant, whitened, nis, threshold, accepted };
        Ok((innovation, factor))
    }

    /// Natural logarithm of the measurement's likelihood, for comparing associations.
    pub fn log_likelihood(&self) -> f64 {
        -0.5 * (self.nis + self.determinant.ln() + M as f64 * std::f64::consts::TAU.ln())
    }
}

/// Chi-square gate: the share of right measurements that it lets pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gate {
    thresholds: [f64; Gate::LARGEST],
}

impl Gate {
    /// Measurements up to this dimension have their threshold computed once, in advance.
    const LARGEST: usize = 6;

    /// No gate: everything passes.
    pub const OPEN: Gate = Gate { thresholds: [f64::INFINITY; Gate::LARGEST] };

    /// A gate that right measurements pass with the given probability in (0, 1], 1 for all.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for any other number.
    pub fn probability(probability: f64) -> Result<Self> {
        loc_core::error::probability("gate probability", probability)?;
        loc_core::error::positive("gate probability", probability)?;
        if probability >= 1.0 {
            return Ok(Gate::OPEN);
        }
        let mut thresholds = [f64::INFINITY; Gate::LARGEST];
        for (index, threshold) in thresholds.iter_mut().enumerate() {
            *threshold = chi_square_quantile(index + 1, probability)?;
        }
        Ok(Gate { thresholds })
    }

    /// The largest NIS that passes, for a measurement of `dimension` numbers (1 to 6; beyond, the
    /// gate is open).
    pub fn threshold(&self, dimension: usize) -> f64 {
        let index = dimension.wrapping_sub(1);
        self.thresholds.get(index).copied().unwrap_or(f64::INFINITY)
    }
}

/// Refuses vectors with NaN or infinity.
pub(crate) fn finite<const M: usize>(what: &'static str, vector: &SVector<f64, M>) -> Result<()> {
    if vector.iter().all(|value| value.is_finite()) {
        return Ok(());
    }
    Err(Error::NotFinite { what, found: format!("{:?}", vector.as_slice()) })
}

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
    /// [`loc_core::Error::NotACovariance`] where it is not positive definite, or not finite.
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
fn not_definite<const M: usize>(s: &SMatrix<f64, M, M>) -> Error {
    // The general routine words the refusal.
    match loc_core::gaussian::cholesky("innovation covariance", s) {
        Err(error) => error.into(),
        Ok(_) => loc_core::Error::OutOfRange {
            what: "smallest pivot of the innovation covariance",
            expected: "a number > 0",
            found: 0.0,
        }
        .into(),
    }
}
