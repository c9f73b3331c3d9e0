//! The scenario that a study runs, as text that settings are put into.

use super::Axis;
use crate::scenario::{Scenario, builtin};
use crate::{Error, Result, config};
use std::path::Path;
use toml::Value;

/// The text of a scenario, with the changes that all runs share.
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

    /// Every setting as `key = value`, a line each: what tells two scenarios apart. The seed is
    /// not among them.
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
