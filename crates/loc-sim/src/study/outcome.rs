//! The figures of a run, and their summary over the runs of one combination of settings.

use super::Job;
use crate::metrics::consistency::RunEvidence;
use crate::metrics::{Alignment, Consistency, ConsistencyFigures, Summary, ends_near};
use crate::record::Run;
use crate::{Error, Result};
use loc_core::stats;
use loc_core::stats::{RunningMoments, mean_interval, wilson_interval};
use serde::{Deserialize, Serialize, Serializer};
use std::fmt;

/// Largest number of steps of a run whose NEES is kept.
const STEPS: usize = 100;

/// Confidence level of bands and intervals.
pub const CONFIDENCE: f64 = 0.95;

/// Figures that differ between runs of the same seed: computing times.
pub const TIMES: [&str; 2] = ["runtime_s", "realtime_factor"];

/// A finished run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunOutcome {
    /// The combination of settings, counted from 0.
    pub cell: usize,
    /// The seed.
    pub seed: u64,
    /// The error of a failed run; the methods then have no figures.
    pub error: Option<String>,
    /// Figures of the run itself: duration and distance.
    pub figures: Vec<(String, Option<f64>)>,
    /// One entry per method, in the order of the study.
    pub methods: Vec<MethodOutcome>,
}

/// One method's part of a finished run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MethodOutcome {
    /// The method.
    pub method: String,
    /// Whether it was localized at the end, see [`ends_near`].
    pub ends_near: Option<bool>,
    /// Its figures of `summary.json`, in that order.
    pub figures: Vec<(String, Option<f64>)>,
    /// Input of the consistency tests.
    pub evidence: RunEvidence,
}

impl RunOutcome {
    /// The figures of a run.
    ///
    /// # Errors
    /// [`crate::Error::UndeterminedAlignment`], and [`loc_core::Error`] for estimates that are not
    /// finite.
    pub fn of(job: Job, run: &Run, align: Alignment) -> Result<Self> {
        let summary = Summary::of(run, Some(job.seed), align)?;
        let pairs = run.methods.iter().zip(&summary.methods);
        let methods = pairs.map(|(record, (method, figures))| {
            Ok(MethodOutcome {
                method: method.clone(),
                ends_near: ends_near(run, record),
                figures: numbers(figures)?,
                evidence: RunEvidence::of(run, record, CONFIDENCE, STEPS)?,
            })
        });
        Ok(RunOutcome {
            cell: job.cell,
            seed: job.seed,
            error: None,
            figures: vec![
                ("duration_s".into(), Some(summary.duration_s)),
                ("distance_m".into(), summary.distance_m),
            ],
            methods: methods.collect::<Result<_>>()?,
        })
    }

    /// A run that ended with an error.
    pub fn failed(job: Job, error: &crate::Error) -> Self {
        let error = Some(error.to_string());
        let (figures, methods) = (Vec::new(), Vec::new());
        RunOutcome { cell: job.cell, seed: job.seed, error, figures, methods }
    }

    /// The run's place in its study.
    pub fn job(&self) -> Job {
        Job { cell: self.cell, seed: self.seed }
    }
}

impl MethodOutcome {
    /// A figure by its name; `None` for an unknown one, or one without a meaning.
    pub fn figure(&self, name: &str) -> Option<f64> {
        self.figures.iter().find(|(known, _)| known == name).and_then(|(_, value)| *value)
    }
}

/// The numbers of a structure, in the order of its fields, by its JSON form. Fields that are no
/// numbers are left out.
fn numbers(figures: &impl Serialize) -> Result<Vec<(String, Option<f64>)>> {
    let failed = |error: serde_json::Error| crate::config::error("figures", &error.to_string());
    let json = serde_json::to_string(figures).map_err(failed)?;
    let Fields(fields) = serde_json::from_str(&json).map_err(failed)?;
    let number = |(name, value): (String, serde_json::Value)| match value {
        serde_json::Value::Null => Some((name, None)),
        value => value.as_f64().map(|number| (name, Some(number))),
    };
    Ok(fields.into_iter().filter_map(number).collect())
}

/// The fields of a JSON object as they come; a map would put them in the order of the alphabet.
struct Fields(Vec<(String, serde_json::Value)>);

impl<'de> Deserialize<'de> for Fields {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl<'de> serde::de::Visitor<'de> for Visitor {
            type Value = Fields;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("an object of figures")
            }
            fn visit_map<A: serde::de::MapAccess<'de>>(
                self,
                mut map: A,
            ) -> Result<Fields, A::Error> {
                let mut fields = Vec::new();
                while let Some(field) = map.next_entry()? {
                    fields.push(field);
                }
                Ok(Fields(fields))
            }
        }
        deserializer.deserialize_map(Visitor)
    }
}

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
    /// Number of runs that ended with an error; they count as no success.
    pub failed: u64,
    /// Number of runs whose success is defined: all or none.
    pub judged: u64,
    /// Number of successes.
    pub successes: u64,
    /// Their share; null where success has no meaning.
    pub success_rate: Option<f64>,
    /// Wilson's 95 % confidence interval of the probability of a success.
    pub success_interval: Option<[f64; 2]>,
    /// Root mean square of the distances to the truth, a number per run.
    pub ate_rmse_m: Option<Spread>,
    /// Root mean square of the heading errors, a number per run.
    pub heading_rmse_deg: Option<Spread>,
    /// Distance to the truth at the end, a number per run.
    pub final_error_m: Option<Spread>,
    /// Computing time of the method, a number per run.
    pub runtime_s: Option<Spread>,
    /// Consistency of its covariances.
    pub consistency: ConsistencyFigures,
    /// The tests behind the latter; for the first combination of settings only.
    #[serde(skip)]
    pub tests: Option<Consistency>,
    /// The root mean square errors themselves; for the first combination of settings only.
    #[serde(skip)]
    pub errors: Vec<f64>,
}

/// Distribution of a figure over runs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// Number of runs that have it.
    pub count: u64,
    /// Its mean.
    pub mean: f64,
    /// 95 % confidence interval of the expected value, by Student's distribution; null for a single
    /// run.
    pub interval: Option<[f64; 2]>,
    /// Median.
    pub median: f64,
    /// 95 % quantile.
    pub p95: f64,
    /// The largest.
    pub max: f64,
    /// Moments, to combine several groups.
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

/// Collects the runs of a group one by one.
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

    /// The group; with `whole` it keeps the data for figures of a single group.
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

/// When a run of a method counts as a success.
///
/// ```
/// use loc_sim::study::Success;
/// let success: Success = "ate_rmse_m<0.1".parse()?;
/// assert_eq!(success.to_string(), "ate_rmse_m < 0.1");
/// # Ok::<(), loc_sim::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Success {
    /// At the end its estimates lie within 0.5 m and 10 deg of the truth, see
    /// [`ends_near`].
    #[default]
    EndsNear,
    /// A figure of `summary.json` lies below a limit.
    Below {
        /// The figure's name.
        figure: String,
        /// The limit.
        limit: f64,
    },
}

impl Success {
    /// Whether a method succeeded; `None` where the figure has no meaning.
    ///
    /// # Errors
    /// [`Error::UnknownName`] for a figure that there is not.
    pub fn of(&self, run: &RunOutcome, method: &MethodOutcome) -> Result<Option<bool>> {
        let Success::Below { figure, limit } = self else { return Ok(method.ends_near) };
        let figures = || method.figures.iter().chain(&run.figures);
        match figures().find(|(name, _)| name == figure) {
            Some((_, value)) => Ok(value.map(|value| value < *limit)),
            None => Err(Error::UnknownName {
                what: "--success",
                expected: figures().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", "),
                found: figure.clone(),
            }),
        }
    }
}

impl std::str::FromStr for Success {
    type Err = Error;

    /// `FIGURE<LIMIT`.
    fn from_str(text: &str) -> Result<Self> {
        let parts = text.split_once('<').map(|(figure, limit)| (figure.trim(), limit.trim()));
        match parts.map(|(figure, limit)| (figure, limit.parse::<f64>())) {
            Some((figure, Ok(limit))) if !figure.is_empty() && limit.is_finite() => {
                Ok(Success::Below { figure: figure.into(), limit })
            }
            _ => Err(crate::config::field("--success", "FIGURE<LIMIT, as ate_rmse_m<0.1", text)),
        }
    }
}

impl fmt::Display for Success {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Success::EndsNear => f.write_str("within 0.5 m and 10 deg of the truth at the end"),
            Success::Below { figure, limit } => write!(f, "{figure} < {limit}"),
        }
    }
}
