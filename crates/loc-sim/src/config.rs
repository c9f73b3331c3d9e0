//! TOML with changes from the command line, and errors that name file, line and key.

use crate::{Error, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

/// Reads a configuration, after applying changes of the form `key.subkey=value`.
pub(crate) fn parse<T: DeserializeOwned>(file: &str, text: &str, changes: &[String]) -> Result<T> {
    if changes.is_empty() {
        return toml::from_str(text).map_err(|e| error(file, &located(text, &e)));
    }
    let config = Value::Table(table(file, text, changes)?);
    let file = format!("{file} with --set {}", changes.join(" --set "));
    config.try_into().map_err(|e: toml::de::Error| error(&file, e.message()))
}

/// The table of a configuration, after changes of the form `key.subkey=value`.
pub(crate) fn table(file: &str, text: &str, changes: &[String]) -> Result<Table> {
    let table: Table = toml::from_str(text).map_err(|e| error(file, &located(text, &e)))?;
    let mut config = Value::Table(table);
    for change in changes {
        apply(&mut config, change).map_err(|message| error("--set", &message))?;
    }
    match config {
        Value::Table(table) => Ok(table),
        _ => Ok(Table::new()),
    }
}

/// Settings after changes of the form `key.subkey=value`; `name` says whose they are.
pub(crate) fn changed<T>(name: &str, settings: T, changes: &[String]) -> Result<T>
where
    T: Serialize + DeserializeOwned,
{
    if changes.is_empty() {
        return Ok(settings);
    }
    let file = format!("{name} with --set {}", changes.join(" --set "));
    let mut config = Value::try_from(&settings).map_err(|e| error(&file, &e.to_string()))?;
    for change in changes {
        apply(&mut config, change).map_err(|message| error("--set", &message))?;
    }
    config.try_into().map_err(|e: toml::de::Error| error(&file, e.message()))
}

pub(crate) fn error(file: &str, message: &str) -> Error {
    Error::Config { file: file.into(), message: message.into() }
}

/// An error about one key of a configuration, which the caller puts into its file.
pub(crate) fn field(key: &str, expected: &str, found: &str) -> Error {
    let what = match found {
        "" => "nothing".to_owned(),
        found => format!("`{found}`"),
    };
    Error::Config { file: key.into(), message: format!("expected {expected}, got {what}") }
}

/// `line 3: unknown field ..` of a TOML error.
fn located(text: &str, error: &toml::de::Error) -> String {
    let line = error
        .span()
        .map_or(1, |span| text.get(..span.start).unwrap_or_default().matches('\n').count() + 1);
    let content = text.lines().nth(line - 1).unwrap_or_default().trim();
    format!("line {line}: `{content}`: {}", error.message().replace('\n', " "))
}

/// Applies one change, `key.subkey=value`; a number in the path picks from an array, from 0.
fn apply(config: &mut Value, change: &str) -> Result<(), String> {
    let (path, value) = change
        .split_once('=')
        .ok_or_else(|| format!("expected key.subkey=value, got `{change}`"))?;
    let keys: Vec<&str> = path.trim().split('.').collect();
    set(config, &keys, parse_value(value.trim()))
        .map_err(|key| format!("expected the key of a table or array, got `{key}` in `{path}`"))
}

/// Puts a value at a path of keys; the error is the key that does not fit.
fn set<'k>(place: &mut Value, keys: &[&'k str], value: Value) -> Result<(), &'k str> {
    let Some((&key, rest)) = keys.split_first() else {
        *place = value;
        return Ok(());
    };
    // A part that is switched off, `tempering = false`, is switched on by any of its keys.
    if matches!(place, Value::Boolean(false)) {
        *place = Value::Table(Table::new());
    }
    let inner = match place {
        Value::Array(array) => key.parse::<usize>().ok().and_then(|index| array.get_mut(index)),
        Value::Table(table) if !key.is_empty() => {
            Some(table.entry(key).or_insert_with(|| Value::Table(Table::new())))
        }
        _ => None,
    };
    set(inner.ok_or(key)?, rest, value)
}

/// A TOML value, or the text itself where it is none: `filter.integration=euler`.
pub(crate) fn parse_value(text: &str) -> Value {
    let parsed: Result<Table, _> = toml::from_str(&format!("value = {text}"));
    let value = parsed.ok().and_then(|mut table| table.remove("value"));
    value.unwrap_or_else(|| Value::String(text.into()))
}
