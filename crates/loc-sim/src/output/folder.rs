//! The folder that a run is written to, whole or not at all.

use super::figures::FigureFile;
use super::{Made, report};
use crate::Result;
use loc_core::Error;
use loc_core::file::in_folder;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// The file that stands for a run that is whole.
const LAST: &str = "summary.json";

/// Files in memory, by name.
#[derive(Debug, Clone, Default)]
pub struct Folder {
    files: Vec<(String, Vec<u8>)>,
}

impl Folder {
    /// Adds a text file.
    pub fn add(&mut self, name: impl Into<String>, text: impl Into<String>) {
        self.add_bytes(name, text.into());
    }

    /// Adds a file of any kind, such as an image.
    pub fn add_bytes(&mut self, name: impl Into<String>, bytes: impl Into<Vec<u8>>) {
        self.files.push((name.into(), bytes.into()));
    }

    /// Adds the files of another folder, but for names that there are already.
    pub fn extend(&mut self, other: &Folder) {
        for (name, bytes) in &other.files {
            if self.bytes(name).is_none() {
                self.add_bytes(name.clone(), bytes.clone());
            }
        }
    }

    /// The names of the files.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.files.iter().map(|(name, _)| name.as_str())
    }

    /// The text of a file; `None` where there is no such file, or one that is no text.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.bytes(name).and_then(|bytes| std::str::from_utf8(bytes).ok())
    }

    /// The content of a file.
    pub fn bytes(&self, name: &str) -> Option<&[u8]> {
        self.files.iter().find(|(known, _)| known == name).map(|(_, bytes)| bytes.as_slice())
    }

    /// Writes the files into `path`, which is made where it is missing.
    ///
    /// Everything is written beside it first; only when that has succeeded do the files take the
    /// place of an earlier run's, `summary.json` last: while it is missing, the folder is not
    /// complete. A folder that could not be filled is not left behind empty. Estimates and figures that the earlier run had and this one has
    /// not are removed, so that the folder shows one run; files of other kinds are left alone.
    ///
    /// # Errors
    /// [`Error::Io`] with the path; an earlier run's files are then as they were.
    pub fn write(&self, path: &Path) -> Result<()> {
        in_folder(path, |path| {
            let staging = path.join(format!(".part-{}", std::process::id()));
            let result = self.write_through(&staging, path);
            // Nothing is left beside the run; a failure to tidy up would hide the first error.
            let _ = fs::remove_dir_all(&staging);
            result
        })
    }

    fn write_through(&self, staging: &Path, path: &Path) -> Result<()> {
        fs::create_dir_all(staging).map_err(Error::io(staging))?;
        for (name, bytes) in &self.files {
            let file = staging.join(name);
            fs::write(&file, bytes).map_err(Error::io(&file))?;
        }
        for entry in fs::read_dir(path).map_err(Error::io(path))? {
            let entry = entry.map_err(Error::io(path))?;
            let name = entry.file_name().to_string_lossy().into_owned();
            if is_ours(&name) && self.bytes(&name).is_none() {
                fs::remove_file(entry.path()).map_err(Error::io(entry.path()))?;
            }
        }
        let _ = fs::remove_file(path.join(LAST));
        let is_last = |name: &str| name == LAST;
        let first = self.names().filter(|name| !is_last(name));
        for name in first.chain(self.names().filter(|name| is_last(name))) {
            let file = path.join(name);
            fs::rename(staging.join(name), &file).map_err(Error::io(&file))?;
        }
        Ok(())
    }
}

/// Whether a file of this name can only come from a run.
fn is_ours(name: &str) -> bool {
    let between = |start, end| name.starts_with(start) && name.ends_with(end);
    name == "truth.tum"
        || between("estimate_", ".tum")
        || between("covariance_", ".csv")
        || super::figures::NAMES.contains(&name)
}

/// What a scenario leaves behind that runs no method: figures with the numbers that belong to them.
#[derive(Debug, Clone)]
pub struct Illustration {
    /// The numbers for people, a line each.
    pub lines: Vec<String>,
    /// The numbers for programs.
    pub summary: Value,
    /// The figures.
    pub figures: Vec<FigureFile>,
    /// Other files: tables of raw numbers, settings.
    pub data: Folder,
}

impl Illustration {
    /// Figures with their numbers and nothing else.
    pub fn new(lines: Vec<String>, summary: Value, figures: Vec<FigureFile>) -> Self {
        Illustration { lines, summary, figures, data: Folder::default() }
    }

    /// All files, ready to be written: `summary.json`, the figures, and `report.html`.
    ///
    /// # Errors
    /// [`crate::Error::Config`] for numbers that cannot be written.
    pub fn files<'a>(&self, title: &str, made: impl Into<Made<'a>>) -> Result<Folder> {
        let mut folder = Folder::default();
        folder.add("summary.json", super::pretty(&self.summary)?);
        folder.add(
            "report.html",
            report::plain(&self.lines.join("\n"), title, made.into(), &self.figures),
        );
        for figure in &self.figures {
            folder.add(figure.file.clone(), figure.svg.clone());
        }
        folder.extend(&self.data);
        Ok(folder)
    }
}
