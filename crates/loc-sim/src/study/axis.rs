//! One setting that is varied, with its values.

use crate::config::{self, parse_value};
use crate::{Error, Result};
use std::collections::BTreeSet;
use std::fmt;
use toml::Value;

/// The most values of a range.
const MAX: usize = 1_000_000;

/// What belongs to the scenario or the study as a whole, and is no setting.
const FIXED: [&str; 6] = ["name", "title", "ids", "seed", "methods", "also_in_frame"];

/// A setting and the values that it takes.
///
/// ```
/// use loc_sim::study::Axis;
/// let axis: Axis = "laser.sigma=0.01:0.05:3".parse()?;
/// let values: Vec<String> = axis.values().iter().map(ToString::to_string).collect();
/// assert_eq!((axis.key(), values.join(" ")), ("laser.sigma", "0.01 0.03 0.05".into()));
/// assert_eq!("filter.integration=euler,midpoint".parse::<Axis>()?.values().len(), 2);
/// # Ok::<(), loc_sim::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    key: String,
    values: Vec<AxisValue>,
}

/// A value of a setting: a TOML value.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisValue(Value);

impl Axis {
    /// The key, as it was given.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// The last part of the key, for headings.
    pub fn short_name(&self) -> &str {
        self.key.rsplit('.').next().unwrap_or(&self.key)
    }

    /// The values, in the order in which they were given.
    pub fn values(&self) -> &[AxisValue] {
        &self.values
    }

    /// The values as numbers; `None` unless all are.
    pub fn numbers(&self) -> Option<Vec<f64>> {
        self.values.iter().map(AxisValue::number).collect()
    }

    /// The change of the configuration that the k-th value stands for: `key=value`.
    pub fn change(&self, k: usize) -> String {
        let value = self.values.get(k).map_or(String::new(), |value| value.0.to_string());
        format!("{}={value}", self.key)
    }
}

impl AxisValue {
    /// The value as a number, where it is one.
    pub fn number(&self) -> Option<f64> {
        match self.0 {
            Value::Integer(value) => Some(value as f64),
            Value::Float(value) => Some(value),
            _ => None,
        }
    }

    /// The value itself.
    pub fn value(&self) -> &Value {
        &self.0
    }
}

impl fmt::Display for AxisValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Value::String(text) => f.pad(text),
            Value::Float(value) => f.pad(&value.to_string()),
            value => f.pad(&value.to_string()),
        }
    }
}

impl std::str::FromStr for Axis {
    type Err = Error;

    /// `key=VALUE,VALUE,..` or `key=FIRST:LAST:COUNT`, evenly spaced with both ends.
    fn from_str(text: &str) -> Result<Self> {
        let refused = |message: String| config::error("--vary", &message);
        let (key, values) = text.split_once('=').ok_or_else(|| {
            refused(format!("expected KEY=VALUE,VALUE,.. or KEY=FIRST:LAST:COUNT, got `{text}`"))
        })?;
        let (key, name) = (key.trim(), format!("--vary {}", key.trim()));
        if key.is_empty() || key.split('.').any(str::is_empty) {
            return Err(refused(format!("expected a key such as filter.particles, got `{key}`")));
        }
        if FIXED.contains(&key) {
            let expected = "a setting: seeds come from --runs and --seed, methods from --method";
            return Err(config::field(&name, expected, key));
        }
        let values = match range(values).map_err(|found| {
            config::field(&name, "FIRST:LAST:COUNT with a COUNT of 2 to 1000000", &found)
        })? {
            Some(values) => values,
            None => split(values).into_iter().map(|text| AxisValue(parse_value(text))).collect(),
        };
        let mut seen = BTreeSet::new();
        for value in &values {
            if matches!(&value.0, Value::String(text) if text.is_empty()) {
                return Err(config::field(&name, "a value between the commas", ""));
            }
            if !seen.insert(value.to_string()) {
                return Err(config::field(&name, "values that differ", &format!("{value} twice")));
            }
        }
        Ok(Axis { key: key.into(), values })
    }
}

/// The values of `FIRST:LAST:COUNT`; `None` for a text of another form, the part that does not fit
/// as an error.
fn range(text: &str) -> Result<Option<Vec<AxisValue>>, String> {
    let parts: Vec<&str> = text.split(':').map(str::trim).collect();
    let [first, last, count] = parts.as_slice() else { return Ok(None) };
    let (Value::Integer(_) | Value::Float(_), Value::Integer(_) | Value::Float(_)) =
        (parse_value(first), parse_value(last))
    else {
        return Ok(None);
    };
    let (Ok(from), Ok(to)) = (first.parse::<f64>(), last.parse::<f64>()) else { return Ok(None) };
    let steps = count.parse::<usize>().ok().filter(|count| (2..=MAX).contains(count));
    let steps = steps.ok_or_else(|| (*count).to_owned())? - 1;
    if !from.is_finite() || !to.is_finite() {
        return Err(text.to_owned());
    }
    let at = |k: usize| rounded(from + (to - from) * (k as f64 / steps as f64));
    let values: Vec<f64> = (0..=steps).map(at).collect();
    let whole = |text: &str| text.parse::<i64>().is_ok();
    // Beyond 2^53 neighbours cannot be told apart anyway.
    let fits = |value: &f64| value.fract().abs() <= 0.0 && value.abs() < 9e15;
    let integers = whole(first) && whole(last) && values.iter().all(fits);
    let value = |value: f64| match integers {
        true => AxisValue(Value::Integer(value as i64)),
        false => AxisValue(Value::Float(value)),
    };
    Ok(Some(values.into_iter().map(value).collect()))
}

/// A number in at most 12 digits: 0.055 where steps of rounding have made 0.05500000000000001.
fn rounded(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

/// The parts between commas that stand in no brackets and no quotes.
fn split(text: &str) -> Vec<&str> {
    let (mut parts, mut start, mut depth, mut quote) = (Vec::new(), 0, 0_i32, None);
    for (at, letter) in text.char_indices() {
        match (letter, quote) {
            (letter, Some(open)) if letter == open => quote = None,
            (_, Some(_)) => {}
            ('"' | '\'', None) => quote = Some(letter),
            ('[' | '{', None) => depth += 1,
            (']' | '}', None) => depth -= 1,
            (',', None) if depth == 0 => {
                parts.push(text[start..at].trim());
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(text[start..].trim());
    parts
}
