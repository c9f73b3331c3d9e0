//! The parameters of a file, taken out one by one; what is left at the end is unknown.

use super::value::Value;
use crate::{Error, Result, config};
use std::collections::BTreeMap;

/// Parameters by name.
#[derive(Debug)]
pub(super) struct Given {
    file: String,
    parameters: BTreeMap<String, (Value, u64)>,
    /// By line, so that they come out in the order of the file.
    warnings: Vec<(u64, String)>,
}

impl Given {
    pub(super) fn new(file: &str) -> Self {
        Given { file: file.to_owned(), parameters: BTreeMap::new(), warnings: Vec::new() }
    }

    /// Adds a parameter, over one of the same name.
    pub(super) fn insert(&mut self, key: String, value: Value, line: u64) {
        self.parameters.insert(key, (value, line));
    }

    /// A finite number that `allowed` says is one; `expected` in words.
    pub(super) fn number(
        &mut self,
        key: &str,
        expected: &str,
        allowed: impl Fn(f64) -> bool,
    ) -> Result<Option<Found<f64>>> {
        self.take(key, expected, |value| match value {
            Value::Integer(value) => Some(*value as f64).filter(|v| allowed(*v)),
            Value::Number(value) => Some(*value).filter(|v| v.is_finite() && allowed(*v)),
            _ => None,
        })
    }

    /// A whole number from `least` on.
    pub(super) fn integer(&mut self, key: &str, least: i64) -> Result<Option<Found<i64>>> {
        self.take(key, &format!("a whole number >= {least}"), |value| match value {
            Value::Integer(value) => Some(*value).filter(|v| *v >= least),
            _ => None,
        })
    }

    pub(super) fn flag(&mut self, key: &str) -> Result<Option<Found<bool>>> {
        self.take(key, "true or false", |value| match value {
            Value::Bool(value) => Some(*value),
            _ => None,
        })
    }

    /// A name that is not empty.
    pub(super) fn name(&mut self, key: &str) -> Result<Option<Found<String>>> {
        self.take(key, "a name", |value| match value {
            Value::Text(text) => Some(text.clone()).filter(|text| !text.trim().is_empty()),
            _ => None,
        })
    }

    /// What stands for one of the `choices`.
    pub(super) fn choice<T: Copy>(
        &mut self,
        key: &str,
        choices: &[(&str, T)],
    ) -> Result<Option<Found<T>>> {
        let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
        self.take(key, &format!("one of {}", names.join(", ")), |value| match value {
            Value::Text(text) => choices.iter().find(|(name, _)| name == text).map(|(_, of)| *of),
            _ => None,
        })
    }

    /// Names those of some parameters that are given, whatever their values, as changing nothing;
    /// in one warning, at the line of the first.
    pub(super) fn pass_over(&mut self, keys: &[impl AsRef<str>], reason: &str) {
        let mut found = Vec::new();
        for key in keys.iter().map(AsRef::as_ref) {
            found.extend(self.parameters.remove(key).map(|(_, line)| (line, key)));
        }
        found.sort_unstable();
        if let Some((line, _)) = found.first() {
            let keys: Vec<&str> = found.iter().map(|(_, key)| *key).collect();
            self.warn(*line, &keys.join(", "), reason);
        }
    }

    pub(super) fn warn(&mut self, line: u64, key: &str, reason: &str) {
        self.warnings.push((line, self.warning(line, key, reason)));
    }

    /// A warning as a line for the user.
    pub(super) fn warning(&self, line: u64, key: &str, reason: &str) -> String {
        format!("{}:{line}: {key}: {reason}", self.file)
    }

    /// All warnings in order of their lines, with one for each parameter that nobody took.
    pub(super) fn into_warnings(mut self) -> Vec<String> {
        for (key, (_, line)) in std::mem::take(&mut self.parameters) {
            self.warn(line, &key, "not a parameter of amcl that is known here");
        }
        self.warnings.sort();
        self.warnings.into_iter().map(|(_, warning)| warning).collect()
    }

    /// An error about the settings as a whole.
    pub(super) fn error(&self, error: &impl ToString) -> Error {
        config::error(&self.file, &error.to_string())
    }

    fn take<T>(
        &mut self,
        key: &str,
        expected: &str,
        read: impl Fn(&Value) -> Option<T>,
    ) -> Result<Option<Found<T>>> {
        let Some((value, line)) = self.parameters.remove(key) else { return Ok(None) };
        match read(&value) {
            Some(value) => Ok(Some(Found { value, line })),
            None => {
                let message = format!("line {line}: {key}: expected {expected}, got {value}");
                Err(config::error(&self.file, &message))
            }
        }
    }
}

/// A value with its line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found<T> {
    pub(super) value: T,
    pub(super) line: u64,
}
