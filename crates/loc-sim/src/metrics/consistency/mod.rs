//! Whether a method is as certain as it has a right to be, over many runs.
//!
//! A covariance is a promise about errors. One run cannot show whether it is kept: its errors hang
//! together, and chance is large. [`Consistency`] takes the runs of one method under many seeds
//! and holds the errors of its poses (NEES), its innovations (NIS) and their order (whiteness)
//! against what honest ones would be; the tests are those of [`loc_core::stats::consistency`].
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

mod evidence;
mod nees;

pub use evidence::RunEvidence;
pub use nees::{pose_nees, pose_nees_with_freedom};

use crate::Result;
use crate::record::{MethodRecord, Run};
use loc_core::stats::consistency::{ChiSquareTally, NeesEnsemble, Whiteness};
use std::ops::RangeInclusive;

/// Longest distance in an order of innovations over which they are compared.
pub const LAGS: usize = 10;

/// The tests of one method over its runs under many seeds.
#[derive(Debug, Clone)]
pub struct Consistency {
    confidence: f64,
    nees: NeesEnsemble,
    nis: ChiSquareTally,
    whiteness: Whiteness,
}

/// What the tests say. A figure without a meaning is `None`, null in JSON: a particle filter has
/// no innovations.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ConsistencyFigures {
    /// The share of honest cases that bands and intervals hold.
    pub confidence: f64,
    /// Number of runs with a covariance.
    pub runs: u64,
    /// Mean NEES; for an honest method the number of uncertain coordinates, 3 in the plane.
    pub nees_mean: Option<f64>,
    /// Mean NEES per degree of freedom; 1 for an honest method, more for one too sure of itself.
    pub nees_per_degree: Option<f64>,
    /// Where its expected value lies, by the scatter from run to run.
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
    /// NIS per degree of freedom; 1 for an honest method.
    pub nis_per_degree: Option<f64>,
    /// The band of the latter.
    pub nis_band: Option<[f64; 2]>,
    /// The share of the measurements whose own NIS lies in its interval.
    pub nis_share_inside: Option<f64>,
    /// Autocorrelation of the innovations at the lags 1, 2, ..
    pub autocorrelation: Vec<Option<f64>>,
    /// How far from 0 the first of them lies at most.
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

    /// Adds what was kept of a run.
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

    /// What the tests say.
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
