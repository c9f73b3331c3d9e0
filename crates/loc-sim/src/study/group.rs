//! What the runs of one combination of settings say about one method.

use super::{CONFIDENCE, MethodOutcome};
use crate::Result;
use crate::metrics::{Consistency, ConsistencyFigures};
use loc_core::stats::{self, RunningMoments, mean_interval, wilson_interval};
use serde::{Serialize, Serializer};

/// One method under one combination of settings, over all its seeds.
#[derive(Debug, Clone, Serialize)]
pub struct Group {
    /// The settings that are varied, with their values.
    #[serde(serialize_with = "as_map")]
    pub settings: Vec<(String, toml::Value)>,
    /// The method.
    pub method: String,
    /// Number of runs.
    pub runs: u64,
    /// How many of them ended with an error; they count as no success.
    pub failed: u64,
    /// How many of them could be judged: all, where success has a meaning.
    pub judged: u64,
    /// How many succeeded.
    pub successes: u64,
    /// Their share; null where success has no meaning.
    pub success_rate: Option<f64>,
    /// The interval of Wilson that holds the probability of a success at 95 %.
    pub success_interval: Option<[f64; 2]>,
    /// Root mean square of the distances to the truth, a number per run.
    pub ate_rmse_m: Option<Spread>,
    /// Root mean square of the heading errors, a number per run.
    pub heading_rmse_deg: Option<Spread>,
    /// Distance to the truth at the end, a number per run.
    pub final_error_m: Option<Spread>,
    /// Time that the method took, a number per run.
    pub runtime_s: Option<Spread>,
    /// Whether its covariances are honest.
    pub consistency: ConsistencyFigures,
    /// The tests behind the latter; for the first combination of settings only.
    #[serde(skip)]
    pub tests: Option<Consistency>,
    /// The root mean square errors themselves; for the first combination of settings only.
    #[serde(skip)]
    pub errors: Vec<f64>,
}

/// How a figure is spread over runs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// How many runs have it.
    pub count: u64,
    /// Its mean.
    pub mean: f64,
    /// The interval that holds the expected value at 95 %, by Student's distribution; null for a
    /// single run.
    pub interval: Option<[f64; 2]>,
    /// Half of the runs lie below.
    pub median: f64,
    /// Nineteen of twenty runs lie below.
    pub p95: f64,
    /// The largest.
    pub max: f64,
    /// From which the spread of several groups together follows.
    #[serde(skip)]
    pub(super) moments: RunningMoments,
}

impl Spread {
    /// The spread of some numbers; `None` without any.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for numbers that are not finite.
    pub fn of(values: &[f64]) -> Result<Option<Self>> {
        let moments = RunningMoments::of(values.iter().copied())?;
        let (Some(mean), Some(max)) = (moments.mean(), moments.max()) else { return Ok(None) };
        Ok(Some(Spread {
            count: moments.count(),
            mean,
            interval: mean_interval(&moments, CONFIDENCE)?.map(|i| [*i.start(), *i.end()]),
            median: stats::median(values)?,
            p95: stats::quantile(values, 0.95)?,
            max,
            moments,
        }))
    }
}

/// Takes the runs of a group one by one.
#[derive(Debug)]
pub(super) struct Gathering {
    method: String,
    runs: u64,
    failed: u64,
    judged: u64,
    successes: u64,
    /// The figures of [`SPREAD`], a number per run.
    figures: [Vec<f64>; SPREAD.len()],
    consistency: Consistency,
}

/// The figures whose spread is shown.
const SPREAD: [&str; 4] = ["ate_rmse_m", "heading_rmse_deg", "final_error_m", "runtime_s"];

impl Gathering {
    pub(super) fn new(method: &str) -> Result<Self> {
        Ok(Gathering {
            method: method.into(),
            runs: 0,
            failed: 0,
            judged: 0,
            successes: 0,
            figures: Default::default(),
            consistency: Consistency::new(CONFIDENCE)?,
        })
    }

    /// A run that ended with an error.
    pub(super) fn fail(&mut self) {
        self.runs += 1;
        self.failed += 1;
        self.judged += 1;
    }

    pub(super) fn take(&mut self, outcome: &MethodOutcome, success: Option<bool>) -> Result<()> {
        self.runs += 1;
        self.judged += u64::from(success.is_some());
        self.successes += u64::from(success == Some(true));
        for (values, name) in self.figures.iter_mut().zip(SPREAD) {
            values.extend(outcome.figure(name));
        }
        self.consistency.push_evidence(&outcome.evidence)
    }

    /// The group; with `whole` it keeps what figures of a single group need.
    pub(super) fn finish(self, settings: Vec<(String, toml::Value)>, whole: bool) -> Result<Group> {
        let [ate, heading, last, runtime] = &self.figures;
        let interval = match self.judged {
            0 => None,
            count => Some(wilson_interval(self.successes, count, CONFIDENCE)?),
        };
        Ok(Group {
            settings,
            runs: self.runs,
            failed: self.failed,
            judged: self.judged,
            successes: self.successes,
            success_rate: (self.judged > 0).then(|| self.successes as f64 / self.judged as f64),
            success_interval: interval.map(|interval| [*interval.start(), *interval.end()]),
            ate_rmse_m: Spread::of(ate)?,
            heading_rmse_deg: Spread::of(heading)?,
            final_error_m: Spread::of(last)?,
            runtime_s: Spread::of(runtime)?,
            consistency: self.consistency.figures(),
            errors: if whole { ate.clone() } else { Vec::new() },
            tests: whole.then_some(self.consistency),
            method: self.method,
        })
    }
}

fn as_map<S: Serializer>(
    settings: &[(String, toml::Value)],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_map(settings.iter().map(|(key, value)| (key, value)))
}
