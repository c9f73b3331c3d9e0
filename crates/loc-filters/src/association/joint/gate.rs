//! The gate of several pairs together.

use crate::Result;
use crate::association::AssociationSettings;
use loc_core::stats::chi_square_quantile;

/// Chi-square thresholds by the number of numbers.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::association) struct JointGate {
    thresholds: Vec<f64>,
}

impl JointGate {
    /// Measurements of one pair have at most so many numbers; larger ones are not gated.
    const LARGEST: usize = 3;

    pub(in crate::association) fn new(probability: f64) -> Result<Self> {
        let mut thresholds = Vec::new();
        if probability < 1.0 {
            for dof in 1..=Self::LARGEST * AssociationSettings::GROUP {
                thresholds.push(chi_square_quantile(dof, probability)?);
            }
        }
        Ok(JointGate { thresholds })
    }

    pub(super) fn threshold(&self, dof: usize) -> f64 {
        self.thresholds.get(dof.wrapping_sub(1)).copied().unwrap_or(f64::INFINITY)
    }
}
