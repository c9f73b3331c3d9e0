//! All combinations of settings and seeds.

use crate::config::{field, parse_value};
use crate::{Error, Result, config};
use std::collections::BTreeSet;
use std::fmt;
use toml::Value;

/// The most runs of a study.
pub const MAX_RUNS: u64 = 1_000_000;

/// A grid of settings, each combination of which (a cell) is run under the same seeds: what
/// differs between two cells is then the setting, not the luck.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    axes: Vec<Axis>,
    cells: usize,
    first_seed: u64,
    runs: u64,
}

/// One run of a study.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Job {
    /// The combination of settings, counted from 0.
    pub cell: usize,
    /// The seed.
    pub seed: u64,
}

impl Grid {
    /// All combinations of the values of `axes`, each under `runs` seeds from `first_seed` on.
    ///
    /// # Errors
    /// [`Error::Config`] for no runs, more than [`MAX_RUNS`], seeds beyond 64 bits, and an axis
    /// that comes twice.
    pub fn new(axes: Vec<Axis>, first_seed: u64, runs: u64) -> Result<Self> {
        if runs == 0 {
            return Err(field("--runs", "at least 1", "0"));
        }
        for (k, axis) in axes.iter().enumerate() {
            if axes[..k].iter().any(|other| other.key() == axis.key()) {
                return Err(field("--vary", "every key once", &format!("{} twice", axis.key())));
            }
        }
        let lengths = axes.iter().map(|axis| axis.values().len() as u128);
        let cells = lengths.fold(1_u128, u128::saturating_mul);
        let total = cells.saturating_mul(u128::from(runs));
        if total > u128::from(MAX_RUNS) {
            let found = format!("{cells} settings x {runs} runs = {total}");
            return Err(field("--runs, --vary", &format!("at most {MAX_RUNS} runs"), &found));
        }
        if first_seed.checked_add(runs - 1).is_none() {
            let found = format!("{runs} seeds from {first_seed} on");
            return Err(field("--seed", &format!("seeds up to {}", u64::MAX), &found));
        }
        // At most MAX_RUNS.
        Ok(Grid { axes, cells: cells as usize, first_seed, runs })
    }

    /// The settings that are varied.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// How many combinations of settings there are.
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// How many seeds each is run under.
    pub fn runs(&self) -> u64 {
        self.runs
    }

    /// The first of the seeds.
    pub fn first_seed(&self) -> u64 {
        self.first_seed
    }

    /// How many runs there are.
    pub fn len(&self) -> usize {
        self.cells * self.runs as usize
    }

    /// Whether there are none, which [`Grid::new`] does not allow.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The run of a number, counted from 0: cell by cell, seed by seed.
    pub fn job(&self, index: usize) -> Job {
        let runs = self.runs as usize;
        Job { cell: index / runs, seed: self.first_seed + (index % runs) as u64 }
    }

    /// The number of a run; `None` for one that is not in the grid.
    pub fn index(&self, job: Job) -> Option<usize> {
        let offset = job.seed.checked_sub(self.first_seed).filter(|offset| *offset < self.runs)?;
        (job.cell < self.cells).then(|| job.cell * self.runs as usize + offset as usize)
    }

    /// Which value each axis has in a cell; the last axis runs fastest.
    pub fn place(&self, cell: usize) -> Vec<usize> {
        let mut rest = cell;
        let mut place: Vec<usize> = self
            .axes
            .iter()
            .rev()
            .map(|axis| {
                let count = axis.values().len();
                let k = rest % count;
                rest /= count;
                k
            })
            .collect();
        place.reverse();
        place
    }

    /// The changes of the configuration that make a cell.
    pub fn changes(&self, cell: usize) -> Vec<String> {
        let pairs = self.axes.iter().zip(self.place(cell));
        pairs.map(|(axis, k)| axis.change(k)).collect()
    }
}

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
/// assert_eq!("filter.robot.integration=euler,midpoint".parse::<Axis>()?.values().len(), 2);
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
    // Beyond 2^53 neighbours are not distinct anyway.
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
