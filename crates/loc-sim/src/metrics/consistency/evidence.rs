//! What the tests of consistency need of a run: far less than the run.

use super::LAGS;
use crate::Result;
use crate::localizer::Whitened;
use crate::record::{MethodRecord, Run};
use loc_core::stats::consistency::{ChiSquareTally, Whiteness};

/// The evidence that one run of one method gives.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct RunEvidence {
    /// Degrees of freedom and NEES at steps of the run; `None` without a covariance.
    pub nees: Vec<Option<(usize, f64)>>,
    /// The NIS of the accepted measurements.
    pub nis: ChiSquareTally,
    /// The autocorrelation of their innovations.
    pub whiteness: Whiteness,
}

impl RunEvidence {
    /// The evidence of a method's part of a run, with the NEES of at most `steps` steps, evenly
    /// taken. Single NIS are held against the interval of `confidence`.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for figures that are not finite, and for a `confidence`
    /// outside \[0, 1).
    pub fn of(run: &Run, record: &MethodRecord, confidence: f64, steps: usize) -> Result<Self> {
        let every = run.truth.len().div_ceil(steps.max(1)).max(1);
        let pairs = record.estimates.iter().zip(&run.truth).step_by(every);
        let nees = pairs.map(|(e, t)| run.nees(e, t.value.pose)).collect();
        let mut nis = ChiSquareTally::new(confidence)?;
        let mut sequences: [Vec<f64>; Whitened::MAX] = Default::default();
        for judgement in record.judgements.iter().map(|j| j.value).filter(|j| j.accepted) {
            if let Some(value) = judgement.nis {
                nis.push(judgement.degrees_of_freedom, value)?;
            }
            for (sequence, value) in sequences.iter_mut().zip(judgement.whitened.iter()) {
                sequence.push(*value);
            }
        }
        let mut whiteness = Whiteness::new(LAGS)?;
        sequences.iter().try_for_each(|sequence| whiteness.push(sequence))?;
        Ok(RunEvidence { nees, nis, whiteness })
    }
}
