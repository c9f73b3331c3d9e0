//! Whether the covariances of a method are consistent with its errors, over many runs.
//!
//! One run cannot show this: its errors are correlated over time. [`Consistency`] takes the runs of
//! one method under many seeds and compares the errors of its poses (NEES), its innovations (NIS)
//! and their autocorrelation (whiteness) with those of a consistent filter; the tests are those of [`loc_core::stats::consistency`].
//!
//! ```
//! use loc_sim::localizer::Method;
//! use loc_sim::metrics::Consistency;
//! use loc_sim::scenario::Scenario;
//! let scenario = Scenario::named("landmark-drive", &[])?;
//! let mut consistency = Consistency::new(0.95)?;
//! for seed in 1..=20 {
//!     let run = scenario.run(Some(seed), Some(&[Method::Ekf]), &mut |_| {})?;
//!     consistency.push(&run, &run.methods[0])?;
//! }
//! let figures = consistency.figures();
//! assert!(figures.nees_share_in_band > Some(0.8));
//! assert!(figures.nis_per_degree > Some(0.9) && figures.nis_per_degree < Some(1.1));
//! # Ok::<(), loc_sim::Error>(())
//! ```

use crate::Result;
use crate::record::{MethodRecord, Run};
use loc_core::stats::consistency::{ChiSquareTally, NeesEnsemble, Whiteness};
use loc_core::{Gaussian, Pose2};
use loc_filters::localizer::{Estimate, Outcome, Residual};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use std::ops::RangeInclusive;

/// Largest lag of the autocorrelation of innovations.
pub const LAGS: usize = 10;

/// The tests of one method over its runs under many seeds.
#[derive(Debug, Clone)]
pub struct Consistency {
    confidence: f64,
    nees: NeesEnsemble,
    nis: ChiSquareTally,
    whiteness: Whiteness,
}

/// The results of the tests. A figure without a meaning is `None`, null in JSON: a particle filter has
/// no innovations.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ConsistencyFigures {
    /// Confidence level of bands and intervals.
    pub confidence: f64,
    /// Number of runs with a covariance.
    pub runs: u64,
    /// Mean NEES; for a consistent method the number of uncertain coordinates, 3 in the plane.
    pub nees_mean: Option<f64>,
    /// Mean NEES per degree of freedom; 1 for a consistent method, more for an overconfident one.
    pub nees_per_degree: Option<f64>,
    /// Confidence interval of its expected value, from the scatter between runs.
    pub nees_interval: Option<[f64; 2]>,
    /// The chi-square band of the mean at one step, per degree of freedom, at the step that most
    /// runs have.
    pub nees_band: Option<[f64; 2]>,
    /// The share of the steps at which the mean lies in its band.
    pub nees_share_in_band: Option<f64>,
    /// Number of accepted measurements with an innovation.
    pub measurements: u64,
    /// Their mean NIS.
    pub nis_mean: Option<f64>,
    /// NIS per degree of freedom; 1 for a consistent method.
    pub nis_per_degree: Option<f64>,
    /// The band of the latter.
    pub nis_band: Option<[f64; 2]>,
    /// The share of the measurements whose own NIS lies in its interval.
    pub nis_share_inside: Option<f64>,
    /// Autocorrelation of the innovations at the lags 1, 2, ..
    pub autocorrelation: Vec<Option<f64>>,
    /// Bound of the first of them for white innovations.
    pub whiteness_bound: Option<f64>,
    /// The share of the lags within their bounds.
    pub white_share: Option<f64>,
}

impl Consistency {
    /// No runs yet.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a `confidence` outside \[0, 1).
    pub fn new(confidence: f64) -> Result<Self> {
        Ok(Consistency {
            confidence,
            nees: NeesEnsemble::new(confidence)?,
            nis: ChiSquareTally::new(confidence)?,
            whiteness: Whiteness::new(LAGS)?,
        })
    }

    /// Adds a method's part of a run.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for figures that are not finite.
    pub fn push(&mut self, run: &Run, record: &MethodRecord) -> Result<()> {
        self.push_evidence(&RunEvidence::of(run, record, self.confidence, usize::MAX)?)
    }

    /// Adds the evidence of a run.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for figures that are not finite.
    pub fn push_evidence(&mut self, evidence: &RunEvidence) -> Result<()> {
        self.nees.push_run(evidence.nees.iter().copied())?;
        self.nis.merge(&evidence.nis);
        self.whiteness.merge(&evidence.whiteness);
        Ok(())
    }

    /// The errors of the poses.
    pub fn nees(&self) -> &NeesEnsemble {
        &self.nees
    }

    /// The innovations, measurement by measurement.
    pub fn nis(&self) -> &ChiSquareTally {
        &self.nis
    }

    /// The order of the innovations.
    pub fn whiteness(&self) -> &Whiteness {
        &self.whiteness
    }

    /// The results of the tests.
    pub fn figures(&self) -> ConsistencyFigures {
        let Consistency { confidence, nees, nis, whiteness } = self;
        let fullest = nees.steps().iter().max_by_key(|step| step.degrees_of_freedom);
        ConsistencyFigures {
            confidence: *confidence,
            runs: nees.runs(),
            nees_mean: nees.mean(),
            nees_per_degree: nees.mean_per_degree(),
            nees_interval: nees.interval_per_degree().map(ends),
            nees_band: fullest.and_then(|step| step.band_per_degree(*confidence)).map(ends),
            nees_share_in_band: nees.share_in_band(),
            measurements: nis.count(),
            nis_mean: nis.mean(),
            nis_per_degree: nis.mean_per_degree(),
            nis_band: nis.band_per_degree().map(ends),
            nis_share_inside: nis.share_inside(),
            autocorrelation: (1..=whiteness.lags()).map(|lag| whiteness.correlation(lag)).collect(),
            whiteness_bound: whiteness.bound(1, *confidence),
            white_share: whiteness.share_within(*confidence),
        }
    }
}

fn ends(range: RangeInclusive<f64>) -> [f64; 2] {
    [*range.start(), *range.end()]
}

/// A covariance whose determinant is smaller than this share of the product of its variances, is
/// singular but for rounding.
const SINGULAR: f64 = 1e-12;

/// Normalised estimation error squared of a pose, over the coordinates that the method is not
/// certain of: chi-square distributed with as many degrees of freedom, 3 for a pose in the plane.
///
/// `None` without a covariance, where nothing is uncertain, or where the covariance is singular but
/// for rounding.
pub fn pose_nees(estimate: &Estimate, truth: Pose2) -> Option<f64> {
    pose_nees_with_freedom(estimate, truth).map(|(_, nees)| nees)
}

/// Degrees of freedom and NEES of a pose, see [`pose_nees`].
pub fn pose_nees_with_freedom(estimate: &Estimate, truth: Pose2) -> Option<(usize, f64)> {
    let covariance = estimate.covariance?;
    let belief = Gaussian { mean: estimate.pose.to_vector(), covariance };
    let error = belief.pose_deviation(truth);
    if covariance.diagonal().iter().all(|variance| *variance > 0.0) {
        let singular = determinant_share(&covariance) < SINGULAR;
        return if singular { None } else { whole(&error, &covariance) };
    }
    let uncertain: Vec<usize> = (0..3).filter(|&i| covariance[(i, i)] > 0.0).collect();
    let n = uncertain.len();
    if n == 0 {
        return None;
    }
    let part = DMatrix::from_fn(n, n, |i, j| covariance[(uncertain[i], uncertain[j])]);
    let error = DVector::from_fn(n, |i, _| error[uncertain[i]]);
    Some((n, error.dot(&part.cholesky()?.solve(&error))))
}

fn whole(error: &Vector3<f64>, covariance: &Matrix3<f64>) -> Option<(usize, f64)> {
    loc_core::stats::nees(error, covariance).ok().map(|nees| (3, nees))
}

/// The determinant by the product of the variances: 1 where nothing is correlated.
fn determinant_share(covariance: &Matrix3<f64>) -> f64 {
    covariance.determinant() / covariance.diagonal().product()
}

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
        let mut sequences: [Vec<f64>; Residual::MAX] = Default::default();
        for outcome in record.outcomes.iter().map(|j| j.value).filter(Outcome::accepted) {
            if let Some(value) = outcome.nis {
                nis.push(outcome.degrees_of_freedom, value)?;
            }
            for (sequence, value) in sequences.iter_mut().zip(outcome.whitened.iter()) {
                sequence.push(*value);
            }
        }
        let mut whiteness = Whiteness::new(LAGS)?;
        sequences.iter().try_for_each(|sequence| whiteness.push(sequence))?;
        Ok(RunEvidence { nees, nis, whiteness })
    }
}
