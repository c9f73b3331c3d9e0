//! What a measurement told a filter: the innovation, and whether it was believed.
//!
//! The innovation is the difference between a measurement and what the filter expected. Held
//! against its own covariance it says whether the measurement fits: its normalised square, the
//! NIS, is chi-square distributed when the filter's idea of the world is right. A [`Gate`] turns
//! measurements away that fit too badly to be true.
//!
//! ```
//! use loc_filters::Gate;
//! let gate = Gate::probability(0.95)?;
//! assert!((gate.threshold(2) - 5.9915).abs() < 1e-4);
//! # Ok::<(), loc_filters::Error>(())
//! ```

use crate::kalman::factor::Factor;
use crate::{Error, Result};
use loc_core::stats::chi_square_quantile;
use nalgebra::{SMatrix, SVector};

/// Residual of one measurement, with all that decided on it.
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
    /// The NIS up to which the measurement was to be accepted.
    pub threshold: f64,
    /// Whether it was accepted; a rejected one has left the filter as it was.
    pub accepted: bool,
}

impl<const M: usize> Innovation<M> {
    /// Holds a residual against its covariance; also returns the Cholesky factor of the latter.
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
