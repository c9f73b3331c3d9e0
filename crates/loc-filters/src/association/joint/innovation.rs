//! The innovation of several pairs together, factorised as it grows.

use crate::association::Pairing;
use nalgebra::SMatrix;
use std::f64::consts::TAU;

/// Residuals of some pairs, whitened by the Cholesky factor of their joint covariance.
#[derive(Debug, Clone, Default)]
pub(super) struct JointInnovation<const M: usize> {
    pub(super) pairs: Vec<(usize, usize)>,
    /// Rows of the factor, one after the other, each with the elements up to its diagonal.
    factor: Vec<f64>,
    whitened: Vec<f64>,
}

impl<const M: usize> JointInnovation<M> {
    /// Number of numbers.
    pub(super) fn len(&self) -> usize {
        self.whitened.len()
    }

    pub(super) fn nis(&self) -> f64 {
        self.whitened.iter().map(|value| value * value).sum()
    }

    /// Logarithm of the determinant of the joint covariance.
    pub(super) fn log_determinant(&self) -> f64 {
        let diagonal = (0..self.len()).map(|row| self.factor[row * (row + 3) / 2]);
        2.0 * diagonal.map(f64::ln).sum::<f64>()
    }

    pub(super) fn log_likelihood(&self) -> f64 {
        -0.5 * (self.nis() + self.log_determinant() + self.len() as f64 * TAU.ln())
    }

    /// Adds a pair; `false`, and no change, where the pairs have no joint covariance.
    pub(super) fn push(&mut self, pairing: &impl Pairing<M>, pair: (usize, usize)) -> bool {
        let rows = self.len();
        if self.grow(pairing, pair).is_none() {
            self.shrink(rows);
            return false;
        }
        self.pairs.push(pair);
        true
    }

    /// Takes the last pair away.
    pub(super) fn pop(&mut self) {
        self.pairs.pop();
        self.shrink(self.len() - M);
    }

    fn shrink(&mut self, rows: usize) {
        self.whitened.truncate(rows);
        self.factor.truncate(rows * (rows + 1) / 2);
    }

    fn grow(&mut self, pairing: &impl Pairing<M>, pair: (usize, usize)) -> Option<()> {
        let own = pairing.innovation(pair.0, pair.1)?;
        let earlier = self.pairs.iter();
        let cross: Vec<SMatrix<f64, M, M>> =
            earlier.map(|other| pairing.cross_covariance(pair, *other)).collect();
        for row in 0..M {
            let covariances = cross.iter().flat_map(|block| (0..M).map(move |c| block[(row, c)]));
            let own_covariances = (0..=row).map(|c| own.covariance[(row, c)]);
            let covariances: Vec<f64> = covariances.chain(own_covariances).collect();
            self.append(&covariances, own.residual[row])?;
        }
        Some(())
    }

    /// Appends one row: its covariances with all rows before it and with itself.
    fn append(&mut self, covariances: &[f64], residual: f64) -> Option<()> {
        let rows = self.whitened.len();
        let mut new = Vec::with_capacity(rows + 1);
        let mut start = 0;
        for (j, covariance) in covariances.iter().enumerate().take(rows) {
            let row = &self.factor[start..=start + j];
            let known: f64 = row.iter().zip(&new).map(|(a, b): (&f64, &f64)| a * b).sum();
            new.push((covariance - known) / row[j]);
            start += j + 1;
        }
        let pivot = covariances[rows] - new.iter().map(|v| v * v).sum::<f64>();
        // Pairs whose joint covariance is singular, or not one at all, say nothing together.
        if !(pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        let explained: f64 = new.iter().zip(&self.whitened).map(|(a, b)| a * b).sum();
        self.whitened.push((residual - explained) / pivot.sqrt());
        new.push(pivot.sqrt());
        self.factor.extend(new);
        Some(())
    }
}
