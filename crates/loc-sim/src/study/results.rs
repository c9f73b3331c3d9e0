//! The results of a study, and the files of its output folder:
//!
//! ```text
//! journal.jsonl    the finished runs, see `journal`
//! runs.csv         a row per run and method: settings, seed, figures; the same to the byte however
//!                  often the study was interrupted and on however many threads it ran
//! runs.parquet     the same table
//! times.csv        the computing times, which differ every time
//! study.json       the figures over all runs
//! *.svg            figures
//! report.html      the whole on one page
//! ```

use super::journal::Journal;
use super::outcome::Gathering;
use super::table::Columns;
use super::{Group, RunOutcome, Study, figures, parquet, table};
use crate::Result;
use crate::output::figures::FigureFile;
use loc_core::Error;
use serde::Serialize;
use std::fs;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// The results of a study.
#[derive(Debug, Clone, Serialize)]
pub struct Results {
    /// Name of the scenario.
    pub scenario: String,
    /// Its title.
    pub title: String,
    /// Number of runs.
    pub runs: u64,
    /// Number of runs that ended with an error.
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
    /// Simulated duration of the first run \[s\].
    pub duration_s: Option<f64>,
    /// One entry per combination of settings and method.
    pub groups: Vec<Group>,
    /// Names of the figures of a run, in their order.
    #[serde(skip)]
    pub(super) run_figures: Vec<String>,
    /// Names of the figures of a method, in their order.
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

/// Rows of a row group in Parquet.
const GROUP: usize = 1 << 16;

/// Writes all files beside the journal: first into a temporary folder, then, when that has
/// succeeded, in place of the existing files.
pub(super) fn write(
    study: &Study,
    journal: &Journal,
    results: &Results,
    folder: &Path,
    command: &str,
) -> Result<()> {
    let staging = folder.join(format!(".part-{}", std::process::id()));
    fs::create_dir_all(&staging).map_err(Error::io(&staging))?;
    let written = stage(study, journal, results, &staging, command).and_then(|names| {
        for name in names {
            let file = folder.join(&name);
            fs::rename(staging.join(name), &file).map_err(Error::io(&file))?;
        }
        Ok(())
    });
    // An error of the clean-up would hide the first error.
    let _ = fs::remove_dir_all(&staging);
    written
}

/// Writes all files into a folder; returns their names.
fn stage(
    study: &Study,
    journal: &Journal,
    results: &Results,
    folder: &Path,
    command: &str,
) -> Result<Vec<String>> {
    let mut names = tables(study, journal, results, folder)?;
    let json = serde_json::to_string_pretty(results)
        .map_err(|error| crate::config::error("study.json", &error.to_string()))?;
    let drawn = figures::all(study, results);
    // The report needs the pictures, not their files' names.
    let pictures: Vec<FigureFile> = drawn
        .iter()
        .map(|figure| FigureFile {
            file: "".into(),
            caption: figure.caption.to_owned().into(),
            svg: figure.svg.clone(),
        })
        .collect();
    let title = format!("Study: {}", results.title);
    let report = crate::output::plain(&table(results), &title, command.into(), &pictures);
    let mut texts =
        vec![("study.json".to_owned(), json + "\n"), ("report.html".to_owned(), report)];
    texts.extend(drawn.into_iter().map(|figure| (figure.file, figure.svg)));
    for (name, text) in texts {
        let file = folder.join(&name);
        fs::write(&file, text).map_err(Error::io(&file))?;
        names.push(name);
    }
    Ok(names)
}

/// The tables, row by row, since they may be larger than the memory.
fn tables(
    study: &Study,
    journal: &Journal,
    results: &Results,
    folder: &Path,
) -> Result<Vec<String>> {
    let columns = Columns::new(study, results);
    let (run_columns, time_columns) = (columns.runs(), columns.times());
    let mut runs = Output::new(folder, "runs.csv")?;
    let mut times = Output::new(folder, "times.csv")?;
    let target = Output::new(folder, "runs.parquet")?;
    let parquet_path = target.path.clone();
    let io = || Error::io(&parquet_path);
    let mut file = parquet::Writer::new(target.file, run_columns.clone()).map_err(io())?;
    runs.put(&table::header(&run_columns))?;
    times.put(&table::header(&time_columns))?;
    let mut waiting = Vec::new();
    journal.for_each(|outcome| {
        for row in columns.run_rows(&outcome)? {
            runs.put(&table::line(&row))?;
            waiting.push(row);
        }
        for row in columns.time_rows(&outcome) {
            times.put(&table::line(&row))?;
        }
        if waiting.len() >= GROUP {
            let values = table::transposed(&run_columns, &waiting);
            file.rows(&values).map_err(io())?;
            waiting.clear();
        }
        Ok(())
    })?;
    file.rows(&table::transposed(&run_columns, &waiting)).map_err(io())?;
    file.finish().map_err(io())?;
    runs.close()?;
    times.close()?;
    Ok(["runs.csv", "times.csv", "runs.parquet"].map(str::to_owned).to_vec())
}

/// A file with its name for errors.
struct Output {
    path: PathBuf,
    file: BufWriter<File>,
}

impl Output {
    fn new(folder: &Path, name: &str) -> Result<Self> {
        let path = folder.join(name);
        let file = BufWriter::new(File::create(&path).map_err(Error::io(&path))?);
        Ok(Output { path, file })
    }

    fn put(&mut self, text: &str) -> Result<()> {
        Ok(self.file.write_all(text.as_bytes()).map_err(Error::io(&self.path))?)
    }

    fn close(mut self) -> Result<()> {
        Ok(self.file.flush().map_err(Error::io(&self.path))?)
    }
}
