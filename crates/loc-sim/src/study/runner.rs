//! Executes the missing runs of a study on several threads, and the scenario that they run.

use super::journal::Journal;
use super::{Axis, Grid, Job, RunOutcome};
use crate::scenario::{Scenario, builtin};
use crate::{Error, Result, config};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;
use toml::Value;

/// Largest time between two calls of `progress`, if no run ends meanwhile.
const PROGRESS_PERIOD: Duration = Duration::from_millis(50);

/// The progress of a study.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StudyProgress {
    /// Runs that were done before this start.
    pub kept: usize,
    /// Runs that are done.
    pub done: usize,
    /// All runs.
    pub total: usize,
}

/// Executes the runs that are missing in the journal and appends each to it. `progress` gets the
/// state and returns whether to continue; runs that have begun are finished in any case. Returns
/// whether all are done.
///
/// The threads take the runs in the order of the grid; each run depends on its setting and its
/// seed alone, so neither the number of threads nor an interruption can change it.
pub(super) fn complete(
    grid: &Grid,
    journal: &mut Journal,
    threads: usize,
    run: &(dyn Fn(Job) -> Result<RunOutcome> + Sync),
    progress: &mut dyn FnMut(StudyProgress) -> bool,
) -> Result<bool> {
    let missing: Vec<usize> = (0..grid.len()).filter(|&index| !journal.has(index)).collect();
    let (kept, total) = (journal.kept(), grid.len());
    let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let mut first_error: Option<Error> = None;
    std::thread::scope(|scope| {
        let (sender, outcomes) = mpsc::channel();
        for _ in 0..threads.clamp(1, missing.len().max(1)) {
            let sender = sender.clone();
            let (missing, next, stop) = (&missing, &next, &stop);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) {
                    let Some(&index) = missing.get(next.fetch_add(1, Ordering::Relaxed)) else {
                        break;
                    };
                    if sender.send(run(grid.job(index))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        loop {
            let done = match outcomes.recv_timeout(PROGRESS_PERIOD) {
                Ok(outcome) => outcome.and_then(|outcome| journal.add(grid, &outcome)),
                Err(RecvTimeoutError::Timeout) => Ok(()),
                Err(RecvTimeoutError::Disconnected) => break,
            };
            if let Err(error) = done {
                stop.store(true, Ordering::Relaxed);
                // The first one is the cause of the others.
                first_error.get_or_insert(error);
            }
            if !progress(StudyProgress { kept, done: journal.kept(), total }) {
                stop.store(true, Ordering::Relaxed);
            }
        }
    });
    let synced = journal.sync();
    match first_error {
        Some(error) => Err(error),
        None => synced.map(|()| journal.kept() == total),
    }
}

/// The scenario that a study runs: its text, with the changes that all runs share.
#[derive(Debug, Clone, PartialEq)]
pub struct StudySource {
    file: String,
    text: String,
    changes: Vec<String>,
}

impl StudySource {
    /// A built-in scenario, with changes of the form `key.subkey=value`.
    ///
    /// # Errors
    /// [`Error::UnknownName`].
    pub fn named(name: &str, changes: &[String]) -> Result<Self> {
        let (file, text) = (format!("scenario {name}"), builtin::text(name)?.to_owned());
        Ok(StudySource { file, text, changes: changes.to_vec() })
    }

    /// A scenario from a TOML file, with changes.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`].
    pub fn read(file: &Path, changes: &[String]) -> Result<Self> {
        let text = std::fs::read_to_string(file).map_err(loc_core::Error::io(file))?;
        Ok(StudySource { file: file.display().to_string(), text, changes: changes.to_vec() })
    }

    /// The scenario with further changes.
    ///
    /// # Errors
    /// [`Error::Config`] for changes that do not fit.
    pub fn scenario(&self, further: &[String]) -> Result<Scenario> {
        let changes: Vec<String> = self.changes.iter().chain(further).cloned().collect();
        Scenario::parse(&self.file, &self.text, &changes)
    }

    /// Every setting as `key = value`, a line each, to compare scenarios; without the seed.
    ///
    /// # Errors
    /// [`Error::Config`] for text that is no TOML.
    pub(super) fn settings(&self) -> Result<Vec<String>> {
        let changes = Scenario::in_full(&self.file, &self.text, &self.changes)?;
        let mut table = config::table(&self.file, &self.text, &changes)?;
        for not_of_runs in ["seed", "title", "ids", "methods"] {
            table.remove(not_of_runs);
        }
        let mut settings = Vec::new();
        list(&mut settings, "", &Value::Table(table));
        Ok(settings)
    }

    /// Checks each value of each axis alone, so that an error names it.
    ///
    /// # Errors
    /// [`Error::Config`].
    pub(super) fn check_axes(&self, axes: &[Axis]) -> Result<()> {
        for axis in axes {
            for k in 0..axis.values().len().min(super::CHECKED) {
                match self.scenario(&[axis.change(k)]) {
                    // Values that only fit together are checked in their combinations.
                    Err(error) if axes.len() == 1 || is_unknown(&error) => {
                        return Err(named(&axis.change(k), &error));
                    }
                    _ => {}
                }
            }
        }
        Ok(())
    }
}

/// Whether an error is about a key, not a value.
fn is_unknown(error: &Error) -> bool {
    let text = error.to_string();
    text.contains("unknown field") || text.contains("expected the key of a table")
}

/// An error of a scenario as one of `--vary`.
fn named(change: &str, error: &Error) -> Error {
    let message = match error {
        Error::Config { message, .. } => message.clone(),
        error => error.to_string(),
    };
    config::error(&format!("--vary {change}"), &message)
}

fn list(settings: &mut Vec<String>, prefix: &str, value: &Value) {
    match value {
        Value::Table(table) => {
            for (key, value) in table {
                let dot = if prefix.is_empty() { "" } else { "." };
                list(settings, &format!("{prefix}{dot}{key}"), value);
            }
        }
        Value::Array(values) if values.iter().any(Value::is_table) => {
            for (k, value) in values.iter().enumerate() {
                list(settings, &format!("{prefix}.{k}"), value);
            }
        }
        value => settings.push(format!("{prefix} = {value}")),
    }
}
