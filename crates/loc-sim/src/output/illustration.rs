//! What a scenario leaves behind that shows one thing and runs no method.

use super::figures::FigureFile;
use super::{Folder, Made, report};
use crate::Result;
use serde_json::Value;

/// Figures with the numbers that belong to them.
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
