//! The histogram filter in one dimension: a robot in a corridor (F5, K1).
//!
//! ```
//! use loc_filters::histogram::LineGrid;
//! let mut belief = LineGrid::uniform(4.0, 1.0)?;
//! belief.correct(|x| if x < 2.0 { 3.0 } else { 1.0 })?;
//! assert_eq!(belief.probabilities(), [0.375, 0.375, 0.125, 0.125]);
//! belief.predict(1.0, 0.0)?;
//! // The wall at 4 m stops the robot: what would drive through it is ruled out.
//! assert!((belief.probabilities()[3] - 1.0 / 7.0).abs() < 1e-12);
//! # Ok::<(), loc_filters::Error>(())
//! ```

use super::Kernel;
use crate::{Error, Result};
use loc_core::error::{in_range, non_negative, positive};

/// Maximum number of cells of a line.
const MAX_CELLS: f64 = 1e7;

/// Nodes and weights of the Gauss-Legendre rule with three points on \[-1/2, 1/2\].
const NODES: [(f64, f64); 3] = [
    (-0.387_298_334_620_741_7, 5.0 / 18.0),
    (0.0, 8.0 / 18.0),
    (0.387_298_334_620_741_7, 5.0 / 18.0),
];

/// A belief over the places of a corridor from 0 to its length, cell by cell.
#[derive(Debug, Clone, PartialEq)]
pub struct LineGrid {
    /// Length of a cell \[m\].
    cell: f64,
    /// Sum 1.
    probabilities: Vec<f64>,
}

impl LineGrid {
    /// A robot anywhere in a corridor of `length` \[m\], in cells of about `cell` \[m\].
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for lengths that are not finite and above 0, and where they
    /// come to more than 10 million cells.
    pub fn uniform(length: f64, cell: f64) -> Result<Self> {
        positive("length of the corridor [m]", length)?;
        positive("length of a cell [m]", cell)?;
        let count = (length / cell).round().max(1.0);
        in_range("cells of the corridor", "at most 1e7", count, |count| count <= MAX_CELLS)?;
        Ok(LineGrid { cell: length / count, probabilities: vec![1.0 / count; count as usize] })
    }

    /// Length of a cell \[m\].
    pub fn cell(&self) -> f64 {
        self.cell
    }

    /// The probabilities, cell by cell; their sum is 1.
    pub fn probabilities(&self) -> &[f64] {
        &self.probabilities
    }

    /// The middles of the cells \[m\].
    pub fn centers(&self) -> impl Iterator<Item = f64> + Clone + '_ {
        (0..self.probabilities.len()).map(|k| self.center(k))
    }

    /// The robot drives `distance` \[m\], backwards if negative, with a normal error of standard
    /// deviation `sigma` \[m\]. Returns the probability with which it would have driven through an
    /// end of the corridor; that is ruled out.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for numbers that are not finite, and
    /// [`loc_core::Error::ImpossibleEvidence`] where the robot would surely have left; the belief
    /// is kept then.
    pub fn predict(&mut self, distance: f64, sigma: f64) -> Result<f64> {
        let kernel = Kernel::new(distance / self.cell, sigma / self.cell)?;
        let mut after = vec![0.0; self.probabilities.len()];
        kernel.spread(&self.probabilities, &mut after, 0);
        let stayed = normalize(&mut after, "motion within the corridor")?;
        self.probabilities = after;
        Ok((1.0 - stayed).max(0.0))
    }

    /// Correction with a measurement, where `likelihood` says how likely it is at a place \[m\], up to a
    /// common factor. A cell has the mean likelihood of its extent, by the three-point
    /// Gauss-Legendre rule. Returns the logarithm of the mean likelihood over the belief.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a likelihood that is negative or not finite, and
    /// [`loc_core::Error::ImpossibleEvidence`] where it is 0 wherever the robot may be; the belief
    /// is kept then.
    pub fn correct(&mut self, likelihood: impl Fn(f64) -> f64) -> Result<f64> {
        let mut after = self.probabilities.clone();
        for (k, probability) in after.iter_mut().enumerate() {
            let mut mean = 0.0;
            for (node, weight) in NODES {
                let place = self.center(k) + node * self.cell;
                mean += weight * non_negative("likelihood", likelihood(place))?;
            }
            *probability *= mean;
        }
        let evidence = normalize(&mut after, "place in the corridor")?;
        self.probabilities = after;
        Ok(evidence.ln())
    }

    /// The middle of the most likely cell \[m\], the first of several.
    pub fn most_likely(&self) -> f64 {
        let mut best = 0;
        for (k, p) in self.probabilities.iter().enumerate() {
            if *p > self.probabilities[best] {
                best = k;
            }
        }
        self.center(best)
    }

    /// The expected place \[m\].
    pub fn mean(&self) -> f64 {
        self.centers().zip(&self.probabilities).map(|(x, p)| x * p).sum()
    }

    /// Variance of the place \[m^2\], the extent of the cells included.
    pub fn variance(&self) -> f64 {
        let mean = self.mean();
        let between: f64 =
            self.centers().zip(&self.probabilities).map(|(x, p)| p * (x - mean).powi(2)).sum();
        between + self.cell.powi(2) / 12.0
    }

    /// The probability that the robot is between two places \[m\], in parts of cells as well.
    pub fn probability(&self, from: f64, to: f64) -> f64 {
        let share = |k: usize| {
            let (low, high) = (k as f64 * self.cell, (k + 1) as f64 * self.cell);
            ((to.min(high) - from.max(low)) / self.cell).clamp(0.0, 1.0)
        };
        self.probabilities.iter().enumerate().map(|(k, p)| p * share(k)).sum()
    }

    fn center(&self, k: usize) -> f64 {
        (k as f64 + 0.5) * self.cell
    }
}

/// Scales to the sum 1; returns the sum that it was.
fn normalize(weights: &mut [f64], what: &'static str) -> Result<f64> {
    let sum: f64 = weights.iter().sum();
    if !(sum > 0.0 && sum.is_finite()) {
        return Err(Error::Core(loc_core::Error::ImpossibleEvidence { what }));
    }
    weights.iter_mut().for_each(|weight| *weight /= sum);
    Ok(sum)
}
