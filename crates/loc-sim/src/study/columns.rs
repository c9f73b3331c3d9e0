//! The table of all runs: a row per run and method.

use super::parquet::{Column, Kind, Values};
use super::{Results, RunOutcome, Study, TIMES};
use crate::Result;
use toml::Value;

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

/// The names of the columns, and how the rows are made.
#[derive(Debug)]
pub(super) struct Columns<'a> {
    study: &'a Study,
    results: &'a Results,
}

impl<'a> Columns<'a> {
    pub(super) fn new(study: &'a Study, results: &'a Results) -> Self {
        Columns { study, results }
    }

    /// What all rows of a run and method begin with: settings, seed, method.
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

    /// The figures of a method that are the same whenever it is run.
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
