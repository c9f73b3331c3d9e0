//! The tables of a study: the one that it prints, the one of all runs, and their CSV form.

use super::parquet::{Column, Kind, Values};
use super::{Group, Results, RunOutcome, Spread, Study, TIMES};
use crate::Result;
use std::fmt::Write;
use toml::Value;

/// Largest number of printed rows.
const ROWS: usize = 40;

/// Accuracy and consistency of the methods; without a line break at its end.
pub fn table(results: &Results) -> String {
    let Results { scenario, runs, seeds, first_seed, .. } = results;
    let last = first_seed + (seeds - 1);
    let runs = if *runs == 1 { "1 run".to_owned() } else { format!("{runs} runs") };
    let mut lines = vec![
        format!("{scenario}: {runs}, seeds {first_seed} to {last}"),
        format!("success: {}; ranges at 95 %", results.success),
        String::new(),
    ];
    lines.extend(columns(results, &accuracy()));
    if results.groups.iter().any(|group| group.consistency.nees_mean.is_some()) {
        lines.push(String::new());
        lines.push(
            "consistency: 1 per degree of freedom, more is overconfident; 95 % in band".into(),
        );
        lines.extend(columns(results, &consistency()));
    }
    if results.groups.len() > ROWS {
        lines.push(format!("{} more rows in study.json", results.groups.len() - ROWS));
    }
    if let Some(error) = &results.first_error {
        lines.push(format!("{} runs ended with an error, the first at {error}", results.failed));
    }
    lines.join("\n")
}

/// A column: its heading and its cells.
type TableColumn = (&'static str, fn(&Group) -> String);

fn accuracy() -> Vec<TableColumn> {
    vec![
        ("success [%]", |group| match (group.success_rate, group.success_interval) {
            (Some(rate), Some([low, high])) => {
                format!("{} ({}..{})", percent(rate), percent(low), percent(high))
            }
            _ => "-".into(),
        }),
        ("ATE [m]", |group| with_range(group.ate_rmse_m, 3)),
        ("p95", |group| figure(group.ate_rmse_m.map(|s| s.p95), 3)),
        ("head [deg]", |group| figure(group.heading_rmse_deg.map(|s| s.mean), 2)),
        ("time [ms]", |group| figure(group.runtime_s.map(|s| 1e3 * s.mean), 1)),
    ]
}

fn consistency() -> Vec<TableColumn> {
    vec![
        ("NEES/dof", |group| match group.consistency.nees_interval {
            Some([low, high]) => {
                let mean = figure(group.consistency.nees_per_degree, 3);
                format!("{mean} ({low:.3}..{high:.3})")
            }
            None => figure(group.consistency.nees_per_degree, 3),
        }),
        ("in band", |group| share(group.consistency.nees_share_in_band)),
        ("NIS/dof (band)", |group| match group.consistency.nis_band {
            Some([low, high]) => {
                let mean = figure(group.consistency.nis_per_degree, 3);
                format!("{mean} ({low:.3}..{high:.3})")
            }
            None => "-".into(),
        }),
        ("white", |group| share(group.consistency.white_share)),
    ]
}

/// The columns under their headings, each in the width of its content.
fn columns(results: &Results, columns: &[TableColumn]) -> Vec<String> {
    let axes = results.varied.iter().map(|key| key.rsplit('.').next().unwrap_or(key).to_owned());
    let mut heading: Vec<String> = axes.collect();
    let left = heading.len() + 1;
    heading.push("method".into());
    heading.extend(columns.iter().map(|(name, _)| (*name).to_owned()));
    let mut rows = vec![heading];
    for group in results.groups.iter().take(ROWS) {
        let setting = |value: &toml::Value| match value {
            toml::Value::String(text) => text.clone(),
            value => value.to_string(),
        };
        let mut row: Vec<String> = group.settings.iter().map(|(_, v)| setting(v)).collect();
        row.push(group.method.clone());
        row.extend(columns.iter().map(|(_, cell)| cell(group)));
        rows.push(row);
    }
    let count = rows[0].len();
    let width = |k: usize| rows.iter().map(|row| row[k].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..count).map(width).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).enumerate().map(|(k, (cell, &width))| match k < left {
            true => format!("{cell:<width$}"),
            false => format!("{cell:>width$}"),
        });
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect()
}

fn with_range(spread: Option<Spread>, digits: usize) -> String {
    match spread {
        Some(Spread { mean, interval: Some([_, high]), .. }) => {
            format!("{mean:.digits$} +- {:.digits$}", high - mean)
        }
        spread => figure(spread.map(|spread| spread.mean), digits),
    }
}

fn figure(value: Option<f64>, digits: usize) -> String {
    match value {
        None => "-".into(),
        // A covariance far too small, or a delocalized method.
        Some(value) if value >= 1e5 => format!("{value:.0e}"),
        Some(value) => format!("{value:.digits$}"),
    }
}

/// In whole percent, but not 100 where there is a failure, nor 0 where there is a success.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    let whole = (1.0..=99.0).contains(&percent) || percent <= 0.0 || percent >= 100.0;
    if whole { format!("{percent:.0}") } else { format!("{percent:.1}") }
}

fn share(share: Option<f64>) -> String {
    share.map_or("-".into(), |share| format!("{} %", percent(share)))
}

/// A value of the table.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Cell {
    Null,
    Bool(bool),
    Integer(i64),
    Seed(u64),
    Number(f64),
    Text(String),
}

/// The columns of the table of all runs (a row per run and method), and how the rows are made.
#[derive(Debug)]
pub(super) struct Columns<'a> {
    study: &'a Study,
    results: &'a Results,
}

impl<'a> Columns<'a> {
    pub(super) fn new(study: &'a Study, results: &'a Results) -> Self {
        Columns { study, results }
    }

    /// The first columns of every row: settings, seed, method.
    fn key_columns(&self) -> Vec<Column> {
        let mut columns = Vec::new();
        for axis in self.study.grid().axes() {
            let all = |fits: fn(&Value) -> bool| axis.values().iter().all(|v| fits(v.value()));
            let kind = if all(Value::is_integer) {
                Kind::Integer
            } else if axis.numbers().is_some() {
                Kind::Number
            } else if all(Value::is_bool) {
                Kind::Bool
            } else {
                Kind::Text
            };
            columns.push(Column::new(axis.key(), kind));
        }
        columns.push(Column::new("seed", Kind::Unsigned));
        columns.push(Column::new("method", Kind::Text));
        columns
    }

    /// The figures of a method that are reproducible.
    fn figures(&self) -> impl Iterator<Item = &str> {
        let names = self.results.method_figures.iter().map(String::as_str);
        names.filter(|name| !TIMES.contains(name))
    }

    /// The columns of `runs.csv` and `runs.parquet`.
    pub(super) fn runs(&self) -> Vec<Column> {
        let mut columns = self.key_columns();
        columns.push(Column::new("success", Kind::Bool));
        let names = self.results.run_figures.iter().map(String::as_str).chain(self.figures());
        columns.extend(names.map(|name| Column::new(name, Kind::Number)));
        columns.push(Column::new("error", Kind::Text));
        columns
    }

    /// The columns of `times.csv`.
    pub(super) fn times(&self) -> Vec<Column> {
        let mut columns = self.key_columns();
        columns.extend(TIMES.map(|name| Column::new(name, Kind::Number)));
        columns
    }

    /// The rows of a run under [`runs`](Columns::runs), one per method.
    pub(super) fn run_rows(&self, outcome: &RunOutcome) -> Result<Vec<Vec<Cell>>> {
        let mut rows = Vec::with_capacity(self.study.records().len());
        for (k, method) in self.study.records().iter().enumerate() {
            let mut row = self.key_cells(outcome, method);
            let part = outcome.methods.get(k);
            let success = match part {
                Some(part) => self.study.success.of(outcome, part)?,
                None => Some(false),
            };
            row.push(success.map_or(Cell::Null, Cell::Bool));
            for name in &self.results.run_figures {
                let figure = outcome.figures.iter().find(|(known, _)| known == name);
                row.push(number(figure.and_then(|(_, value)| *value)));
            }
            for name in self.figures() {
                row.push(number(part.and_then(|part| part.figure(name))));
            }
            row.push(outcome.error.clone().map_or(Cell::Null, Cell::Text));
            rows.push(row);
        }
        Ok(rows)
    }

    /// The rows of a run under [`times`](Columns::times).
    pub(super) fn time_rows(&self, outcome: &RunOutcome) -> Vec<Vec<Cell>> {
        let row = |(k, method): (usize, &String)| {
            let mut row = self.key_cells(outcome, method);
            let part = outcome.methods.get(k);
            row.extend(TIMES.map(|name| number(part.and_then(|part| part.figure(name)))));
            row
        };
        self.study.records().iter().enumerate().map(row).collect()
    }

    fn key_cells(&self, outcome: &RunOutcome, method: &str) -> Vec<Cell> {
        let settings = self.study.settings_of(outcome.cell);
        let columns = self.key_columns();
        let mut cells: Vec<Cell> = settings
            .into_iter()
            .zip(&columns)
            .map(|((_, value), column)| setting(&value, column.kind))
            .collect();
        cells.push(Cell::Seed(outcome.seed));
        cells.push(Cell::Text(method.to_owned()));
        cells
    }
}

fn number(value: Option<f64>) -> Cell {
    value.map_or(Cell::Null, Cell::Number)
}

fn setting(value: &Value, kind: Kind) -> Cell {
    match (value, kind) {
        (Value::Integer(value), Kind::Integer) => Cell::Integer(*value),
        (Value::Integer(value), Kind::Number) => Cell::Number(*value as f64),
        (Value::Float(value), Kind::Number) => Cell::Number(*value),
        (Value::Boolean(value), Kind::Bool) => Cell::Bool(*value),
        (Value::String(text), _) => Cell::Text(text.clone()),
        (value, _) => Cell::Text(value.to_string()),
    }
}

/// Rows as columns of their kinds; a cell of another kind becomes null.
pub(super) fn transposed(columns: &[Column], rows: &[Vec<Cell>]) -> Vec<Values> {
    let column = |(k, column): (usize, &Column)| {
        let cells = || rows.iter().map(move |row| row.get(k).unwrap_or(&Cell::Null));
        match column.kind {
            Kind::Bool => Values::Bool(cells().map(as_bool).collect()),
            Kind::Integer => Values::Integer(cells().map(as_integer).collect()),
            Kind::Unsigned => Values::Unsigned(cells().map(as_seed).collect()),
            Kind::Number => Values::Number(cells().map(as_number).collect()),
            Kind::Text => Values::Text(cells().map(as_text).collect()),
        }
    };
    columns.iter().enumerate().map(column).collect()
}

fn as_bool(cell: &Cell) -> Option<bool> {
    if let Cell::Bool(value) = cell { Some(*value) } else { None }
}

fn as_integer(cell: &Cell) -> Option<i64> {
    if let Cell::Integer(value) = cell { Some(*value) } else { None }
}

fn as_seed(cell: &Cell) -> Option<u64> {
    if let Cell::Seed(value) = cell { Some(*value) } else { None }
}

fn as_number(cell: &Cell) -> Option<f64> {
    if let Cell::Number(value) = cell { Some(*value) } else { None }
}

fn as_text(cell: &Cell) -> Option<String> {
    if let Cell::Text(text) = cell { Some(text.clone()) } else { None }
}

/// The first line.
/// The header of a CSV table (RFC 4180, with line feeds).
pub(super) fn header(columns: &[Column]) -> String {
    let cells: Vec<Cell> = columns.iter().map(|c| Cell::Text(c.name.clone())).collect();
    line(&cells)
}

/// A row with its line feed.
/// A row of a CSV table: a null is empty, numbers have all digits that they need.
pub(super) fn line(cells: &[Cell]) -> String {
    let mut line = String::new();
    for (k, cell) in cells.iter().enumerate() {
        if k > 0 {
            line.push(',');
        }
        // Writing to a String cannot fail.
        let _ = match cell {
            Cell::Null => Ok(()),
            Cell::Bool(value) => write!(line, "{value}"),
            Cell::Integer(value) => write!(line, "{value}"),
            Cell::Seed(value) => write!(line, "{value}"),
            Cell::Number(value) => write!(line, "{value}"),
            Cell::Text(text) => write!(line, "{}", quoted(text)),
        };
    }
    line.push('\n');
    line
}

fn quoted(text: &str) -> String {
    let plain = !text.contains(['"', ',', '\n', '\r']) && !text.is_empty();
    if plain { text.to_owned() } else { format!("\"{}\"", text.replace('"', "\"\"")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_read_back_by_any_reader() {
        let cells = [
            Cell::Null,
            Cell::Bool(true),
            Cell::Integer(-3),
            Cell::Seed(u64::MAX),
            Cell::Number(0.1 + 0.2),
            Cell::Text("a,\"b\"\n".into()),
            Cell::Text(String::new()),
        ];
        let expected = ",true,-3,18446744073709551615,0.30000000000000004,\"a,\"\"b\"\"\n\",\"\"\n";
        assert_eq!(line(&cells), expected);
    }
}
