//! TOML with changes from the command line, and errors that name file, line and key.

use crate::localizer::MethodSettings;
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
    config.try_into().map_err(|e: toml::de::Error| error(&file, &explained(e.message())))
}

/// Checks the section `[filter]` of a configuration, which is otherwise read as a table and put over
/// defaults that are known later.
pub(crate) fn check_filter(file: &str, text: &str, changes: &[String]) -> Result<()> {
    /// The section alone; all others are passed over.
    #[derive(serde::Deserialize)]
    struct Section {
        #[serde(default, rename = "filter")]
        _filter: MethodSettings,
    }
    parse::<Section>(file, text, changes).map(|_| ())
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
    config.try_into().map_err(|e: toml::de::Error| error(&file, &explained(e.message())))
}

/// Applies one change, `key.subkey=value`, to a table.
pub(crate) fn change(table: &mut Table, change: &str) -> Result<()> {
    let mut config = Value::Table(std::mem::take(table));
    let result = apply(&mut config, change);
    if let Value::Table(changed) = config {
        *table = changed;
    }
    result.map_err(|message| error("change", &message))
}

pub(crate) fn error(file: &str, message: &str) -> Error {
    Error::Config { file: file.into(), message: message.into() }
}

/// Keys of version 0.1 that are elsewhere now.
const MOVED: [(&str, &str); 26] = [
    ("gate_probability", "filter.robot.gate_probability"),
    ("integration", "filter.robot.integration"),
    ("horizon_s", "filter.robot.horizon"),
    ("odometry", "filter.robot.odometry"),
    ("camera", "filter.robot.camera, or filter.slam.robot.camera for SLAM alone"),
    ("association_probability", "association.gate_probability"),
    ("association", "association.rule"),
    ("min_ratio", "association.min_ratio"),
    ("merge_ratio", "map.merge_ratio"),
    ("max_landmarks", "map.max_landmarks"),
    ("confirm_score", "map.confirm_score"),
    ("contradiction_cost", "map.contradiction_cost"),
    ("scale_sigma", "range_bias.scale_sigma of fusion, bias.scale_sigma of lateration"),
    ("offset_sigma_m", "range_bias.offset_sigma of fusion, bias.offset_sigma of lateration"),
    ("alpha_slow", "recovery.alpha_slow"),
    ("alpha_fast", "recovery.alpha_fast"),
    ("motion", "filter.robot.path"),
    ("heading_deg", "theta = \"6 deg\""),
    ("x_m", "x"),
    ("start", "start_sigma"),
    ("position_sigma_m", "start_sigma.position (rail.position_sigma on a rail)"),
    ("heading_sigma_deg", "start_sigma.heading = \"6 deg\""),
    ("forward_m", "mounting = { x = .. }"),
    ("slip_rate_per_s", "slip_rate"),
    ("left_m", "mounting = { y = .. }"),
    ("yaw_deg", "mounting = { theta = \"6 deg\" }"),
];

/// What became of a key that is not known: its new place, or its new name without a unit.
fn renamed(message: &str) -> Option<String> {
    let key = message.split_once("unknown field `")?.1.split_once('`')?.0;
    if let Some((_, place)) = MOVED.iter().find(|(old, _)| *old == key) {
        return Some(format!("`{key}` is now {place}"));
    }
    let suffixes = ["_deg_s2", "_deg_s", "_deg", "_m_s2", "_m_s", "_m", "_s"];
    let (name, suffix) = suffixes.iter().find_map(|s| Some((key.strip_suffix(s)?, *s)))?;
    Some(match suffix {
        "_deg" => format!("`{key} = 6` is now `{name} = \"6 deg\"`"),
        "_deg_s" => format!("`{key} = 6` is now `{name} = \"6 deg/s\"`"),
        "_deg_s2" => format!("`{key} = 6` is now `{name} = \"6 deg/s^2\"`"),
        _ => format!("`{key}` is now `{name}`, in SI units"),
    })
}

/// The message of a TOML error, with the new name of an old key.
fn explained(message: &str) -> String {
    if message.contains("expected struct AssociationSettings") {
        return format!("`association` is now association.rule ({message})");
    }
    match renamed(message) {
        Some(hint) => format!("{hint} ({message})"),
        None => message.to_owned(),
    }
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
    format!("line {line}: `{content}`: {}", explained(error.message()).replace('\n', " "))
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

/// A TOML value, or the text itself where it is none: `filter.robot.integration=euler`.
pub(crate) fn parse_value(text: &str) -> Value {
    let parsed: Result<Table, _> = toml::from_str(&format!("value = {text}"));
    let value = parsed.ok().and_then(|mut table| table.remove("value"));
    value.unwrap_or_else(|| Value::String(text.into()))
}
