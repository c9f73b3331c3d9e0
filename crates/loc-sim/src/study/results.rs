//! The figures of a study.

use super::group::Gathering;
use super::journal::Journal;
use super::{Group, RunOutcome, Study};
use crate::Result;
use serde::Serialize;

/// What a study found out.
#[derive(Debug, Clone, Serialize)]
pub struct Results {
    /// Name of the scenario.
    pub scenario: String,
    /// Its title.
    pub title: String,
    /// Number of runs.
    pub runs: u64,
    /// How many of them ended with an error.
    pub failed: u64,
    /// The first of these errors, with its place.
    pub first_error: Option<String>,
    /// The first seed.
    pub first_seed: u64,
    /// Seeds per combination of settings.
    pub seeds: u64,
    /// The settings that are varied.
    pub varied: Vec<String>,
    /// When a run counts as a success.
    pub success: String,
    /// How long a run lasts for the robot, in the first run \[s\].
    pub duration_s: Option<f64>,
    /// One entry per combination of settings and method.
    pub groups: Vec<Group>,
    /// Names of the figures of a run, as they come.
    #[serde(skip)]
    pub(super) run_figures: Vec<String>,
    /// Names of the figures of a method, as they come.
    #[serde(skip)]
    pub(super) method_figures: Vec<String>,
}

impl Results {
    /// The figures over the runs that a journal holds.
    pub(super) fn of(study: &Study, journal: &Journal) -> Result<Self> {
        let grid = study.grid();
        let mut results = Results {
            scenario: study.scenario.name.clone(),
            title: study.scenario.title.clone(),
            runs: 0,
            failed: 0,
            first_error: None,
            first_seed: grid.first_seed(),
            seeds: grid.runs(),
            varied: grid.axes().iter().map(|axis| axis.key().to_owned()).collect(),
            success: study.success.to_string(),
            duration_s: None,
            groups: Vec::new(),
            run_figures: Vec::new(),
            method_figures: Vec::new(),
        };
        let mut cell = Cell::new(study, 0)?;
        journal.for_each(|outcome| {
            if outcome.cell != cell.number {
                let full = std::mem::replace(&mut cell, Cell::new(study, outcome.cell)?);
                full.finish(study, &mut results)?;
            }
            results.note(&outcome);
            cell.take(study, &outcome)
        })?;
        cell.finish(study, &mut results)?;
        Ok(results)
    }

    fn note(&mut self, outcome: &RunOutcome) {
        self.runs += 1;
        if let Some(error) = &outcome.error {
            self.failed += 1;
            let place = format!("setting {}, seed {}", outcome.cell + 1, outcome.seed);
            self.first_error.get_or_insert_with(|| format!("{place}: {error}"));
        }
        let duration = outcome.figures.iter().find(|(name, _)| name == "duration_s");
        self.duration_s = self.duration_s.or(duration.and_then(|(_, value)| *value));
        union(&mut self.run_figures, &outcome.figures);
        for method in &outcome.methods {
            union(&mut self.method_figures, &method.figures);
        }
    }
}

/// The combination of settings whose runs are being read.
struct Cell {
    number: usize,
    gatherings: Vec<Gathering>,
    any: bool,
}

impl Cell {
    fn new(study: &Study, number: usize) -> Result<Self> {
        let methods = study.records().iter().map(|name| Gathering::new(name));
        Ok(Cell { number, gatherings: methods.collect::<Result<_>>()?, any: false })
    }

    fn take(&mut self, study: &Study, outcome: &RunOutcome) -> Result<()> {
        self.any = true;
        if outcome.error.is_some() {
            self.gatherings.iter_mut().for_each(Gathering::fail);
            return Ok(());
        }
        for (gathering, method) in self.gatherings.iter_mut().zip(&outcome.methods) {
            gathering.take(method, study.success.of(outcome, method)?)?;
        }
        Ok(())
    }

    fn finish(self, study: &Study, results: &mut Results) -> Result<()> {
        let whole = results.groups.len() < self.gatherings.len();
        for gathering in self.gatherings.into_iter().filter(|_| self.any) {
            results.groups.push(gathering.finish(study.settings_of(self.number), whole)?);
        }
        Ok(())
    }
}

/// Adds the names that are new.
fn union(names: &mut Vec<String>, figures: &[(String, Option<f64>)]) {
    // Every run has the same ones, in all but odd cases.
    if names.len() == figures.len() && names.iter().zip(figures).all(|(a, (b, _))| a == b) {
        return;
    }
    for (name, _) in figures {
        if !names.contains(name) {
            names.push(name.clone());
        }
    }
}
