//! The NEES of many runs.

use crate::Result;
use crate::error::non_negative;
use crate::stats::chi_square::{check_confidence, mean_band};
use crate::stats::{RunningMoments, mean_interval};
use std::ops::RangeInclusive;

/// NEES over the steps of many runs of one experiment, each with other random numbers.
///
/// The errors of one run hang together from step to step, so one run proves little. The same step
/// of many runs gives independent values, and their mean must lie in a narrow band: the test is
/// the share of the steps at which it does.
#[derive(Debug, Clone, PartialEq)]
pub struct NeesEnsemble {
    confidence: f64,
    steps: Vec<NeesStep>,
    runs: RunningMoments,
    sum: f64,
    count: u64,
}

/// What one step of all runs adds up to.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NeesStep {
    /// Number of runs that have this step.
    pub runs: u64,
    /// Degrees of freedom of their values together.
    pub degrees_of_freedom: u64,
    /// Sum of their values.
    pub sum: f64,
}

impl NeesStep {
    /// The mean per degree of freedom; `None` without values.
    pub fn mean_per_degree(&self) -> Option<f64> {
        let freedom = self.degrees_of_freedom;
        (freedom > 0).then(|| self.sum / freedom as f64)
    }

    /// Where [`mean_per_degree`](NeesStep::mean_per_degree) lies with probability `confidence` if
    /// the covariances are right; `None` without values.
    pub fn band_per_degree(&self, confidence: f64) -> Option<RangeInclusive<f64>> {
        mean_band(self.degrees_of_freedom, confidence)
    }
}

impl NeesEnsemble {
    /// No runs yet; bands hold what is right with probability `confidence`.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a `confidence` outside \[0, 1).
    pub fn new(confidence: f64) -> Result<Self> {
        Ok(NeesEnsemble {
            confidence: check_confidence(confidence)?,
            steps: Vec::new(),
            runs: RunningMoments::new(),
            sum: 0.0,
            count: 0,
        })
    }

    /// Adds a run: for each step the degrees of freedom and the NEES, or `None` where there was
    /// no covariance. Runs may end early.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a value that is negative or not finite; the run is then
    /// left out.
    pub fn push_run(&mut self, nees: impl IntoIterator<Item = Option<(usize, f64)>>) -> Result<()> {
        let values: Vec<_> = nees.into_iter().collect();
        for (_, value) in values.iter().flatten() {
            non_negative("NEES", *value)?;
        }
        self.steps.resize(self.steps.len().max(values.len()), NeesStep::default());
        let mut run = NeesStep::default();
        for (step, value) in self.steps.iter_mut().zip(&values) {
            let Some((freedom, value)) = *value else { continue };
            for sums in [step, &mut run] {
                sums.runs += 1;
                sums.degrees_of_freedom += freedom as u64;
                sums.sum += value;
            }
        }
        self.sum += run.sum;
        self.count += run.runs;
        match run.mean_per_degree() {
            Some(mean) => self.runs.push(mean),
            None => Ok(()),
        }
    }

    /// How many runs had values.
    pub fn runs(&self) -> u64 {
        self.runs.count()
    }

    /// What each step of all runs adds up to.
    pub fn steps(&self) -> &[NeesStep] {
        &self.steps
    }

    /// The mean of all values; the dimension of the state where the covariances are right. `None`
    /// without values.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }

    /// The mean over the runs of their mean NEES per degree of freedom: 1 where the covariances
    /// are right. `None` without values.
    pub fn mean_per_degree(&self) -> Option<f64> {
        self.runs.mean()
    }

    /// Where the expected value of [`mean_per_degree`](NeesEnsemble::mean_per_degree) lies, by the
    /// scatter from run to run: honest where this holds 1. `None` for fewer than two runs.
    ///
    /// The steps of a run hang together in ways that no table knows, hence the scatter.
    pub fn interval_per_degree(&self) -> Option<RangeInclusive<f64>> {
        mean_interval(&self.runs, self.confidence).ok().flatten()
    }

    /// The share of the steps at which the mean over the runs lies in its chi-square band. `None`
    /// without values.
    pub fn share_in_band(&self) -> Option<f64> {
        let (mut steps, mut inside) = (0_u64, 0_u64);
        for step in &self.steps {
            let band = step.band_per_degree(self.confidence);
            if let (Some(mean), Some(band)) = (step.mean_per_degree(), band) {
                steps += 1;
                inside += u64::from(band.contains(&mean));
            }
        }
        (steps > 0).then(|| inside as f64 / steps as f64)
    }
}
