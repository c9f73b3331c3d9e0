//! The files of a finished study.
//!
//! ```text
//! journal.jsonl    the finished runs, see `journal`
//! runs.csv         a row per run and method: settings, seed, figures; the same to the byte however
//!                  often the study was interrupted and on however many threads it ran
//! runs.parquet     the same table
//! times.csv        what differs every time: how long the methods took
//! study.json       the figures over all runs
//! *.svg            the figures to look at
//! report.html      all of it on one page
//! ```

use super::columns::{self, Columns};
use super::journal::Journal;
use super::{Results, Study, csv, figures, parquet, table};
use crate::Result;
use crate::output::figures::FigureFile;
use loc_core::Error;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Rows of a row group in Parquet.
const GROUP: usize = 1 << 16;

/// Writes everything beside the journal: first into a folder of its own, then, when that has
/// succeeded, in place of the files of an earlier time.
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
    // A failure to tidy up would hide the first error.
    let _ = fs::remove_dir_all(&staging);
    written
}

/// Writes all files into a folder; the answer is their names.
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
    runs.put(&csv::header(&run_columns))?;
    times.put(&csv::header(&time_columns))?;
    let mut waiting = Vec::new();
    journal.for_each(|outcome| {
        for row in columns.run_rows(&outcome)? {
            runs.put(&csv::line(&row))?;
            waiting.push(row);
        }
        for row in columns.time_rows(&outcome) {
            times.put(&csv::line(&row))?;
        }
        if waiting.len() >= GROUP {
            let values = columns::transposed(&run_columns, &waiting);
            file.rows(&values).map_err(io())?;
            waiting.clear();
        }
        Ok(())
    })?;
    file.rows(&columns::transposed(&run_columns, &waiting)).map_err(io())?;
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
