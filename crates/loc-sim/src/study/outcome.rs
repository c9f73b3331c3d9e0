//! What is kept of a run: its figures, not its path.

use super::Job;
use crate::Result;
use crate::metrics::consistency::RunEvidence;
use crate::metrics::{Alignment, Summary, ends_near};
use crate::record::Run;
use serde::{Deserialize, Serialize};

/// NEES is kept at no more steps of a run than this.
const STEPS: usize = 100;

/// The share of honest cases that bands and intervals hold.
pub const CONFIDENCE: f64 = 0.95;

/// Figures that differ from run to run of the same seed: those of time.
pub const TIMES: [&str; 2] = ["runtime_s", "realtime_factor"];

/// A finished run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunOutcome {
    /// The combination of settings, counted from 0.
    pub cell: usize,
    /// The seed.
    pub seed: u64,
    /// What went wrong; the methods then have no figures.
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
    /// Whether it knew at the end where the robot was, see [`ends_near`].
    pub ends_near: Option<bool>,
    /// Its figures of `summary.json`, in that order.
    pub figures: Vec<(String, Option<f64>)>,
    /// What the tests of consistency need.
    pub evidence: RunEvidence,
}

impl RunOutcome {
    /// What is kept of a run.
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
    /// A figure by its name; `None` for one that there is not, or that has no meaning.
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
