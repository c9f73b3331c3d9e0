//! Text tables of numbers, read with errors that name file, line and column.
//!
//! The recordings of the field are lines of columns, separated by white space or commas, with `#`
//! comments. Every reader of this workspace goes through here, so a broken file is reported the
//! same way everywhere.
//!
//! ```
//! use loc_core::table::Table;
//! let table = Table::parse("demo.txt", "# t x\n0.0 1.5\n0.1 1.6\n", &["t", "x"]);
//! let xs: Vec<f64> = table.rows().map(|row| row?.number("x")).collect::<Result<_, _>>()?;
//! assert_eq!(xs, [1.5, 1.6]);
//! # Ok::<(), loc_core::Error>(())
//! ```

use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// A text table in memory, with the names of its columns.
#[derive(Debug, Clone)]
pub struct Table {
    file: PathBuf,
    text: String,
    columns: Vec<String>,
    optional: usize,
}

/// One line of a [`Table`].
#[derive(Debug)]
pub struct Row<'a> {
    table: &'a Table,
    line: usize,
    fields: Vec<&'a str>,
}

impl Table {
    /// Reads a file whose lines hold the given columns, in this order.
    ///
    /// # Errors
    /// [`Error::Io`] where the file cannot be read or is not UTF-8.
    pub fn read(file: impl AsRef<Path>, columns: &[&str]) -> Result<Self> {
        let file = file.as_ref();
        let text = std::fs::read_to_string(file).map_err(Error::io(file))?;
        Ok(Table::parse(file, text, columns))
    }

    /// The same over a text in memory; `file` is only named in errors.
    pub fn parse(file: impl Into<PathBuf>, text: impl Into<String>, columns: &[&str]) -> Self {
        let columns = columns.iter().map(|&c| c.to_owned()).collect();
        let mut text = text.into();
        // Some editors begin their files with a byte-order mark, which is no data.
        if text.starts_with('\u{feff}') {
            text.drain(..'\u{feff}'.len_utf8());
        }
        Table { file: file.into(), text, columns, optional: 0 }
    }

    /// Lets the last `count` columns be missing from a line.
    #[must_use]
    pub fn with_optional(mut self, count: usize) -> Self {
        self.optional = count.min(self.columns.len());
        self
    }

    /// The lines that hold data: neither blank, nor a comment, nor a header that repeats the
    /// column names.
    pub fn rows(&self) -> impl Iterator<Item = Result<Row<'_>>> {
        let lines = self.text.lines().enumerate();
        lines.filter_map(|(index, line)| self.row(index + 1, line).transpose())
    }

    /// The file, as errors name it.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// An error at a line of this table.
    pub fn error(&self, line: usize, field: &str, expected: &str, found: &str) -> Error {
        Error::Parse {
            file: self.file.clone(),
            line,
            field: field.to_owned(),
            expected: expected.to_owned(),
            found: found.to_owned(),
        }
    }

    fn row<'a>(&'a self, line: usize, text: &'a str) -> Result<Option<Row<'a>>> {
        let text = text.trim();
        if text.is_empty() || text.starts_with('#') || self.is_header(text) {
            return Ok(None);
        }
        let fields = split(text);
        if fields.len() < self.columns.len() - self.optional {
            let missing = &self.columns[fields.len()];
            let found = format!("the end of the line after {} columns", fields.len());
            return Err(self.error(line, missing, "a value", &found));
        }
        if fields.len() > self.columns.len() {
            let expected = format!("{} columns ({})", self.columns.len(), self.columns.join(" "));
            let found = format!("{} columns", fields.len());
            return Err(self.error(line, "line", &expected, &found));
        }
        Ok(Some(Row { table: self, line, fields }))
    }

    fn is_header(&self, text: &str) -> bool {
        let fields = split(text);
        fields.len() <= self.columns.len()
            && fields.len() >= self.columns.len() - self.optional
            && fields.iter().zip(&self.columns).all(|(field, name)| field == name)
    }
}

impl Row<'_> {
    /// Line number in the file, counted from 1.
    pub fn line(&self) -> usize {
        self.line
    }

    /// The field of a column as a finite number.
    ///
    /// # Errors
    /// [`Error::Parse`] where the column is missing, holds text, NaN or infinity.
    pub fn number(&self, column: &str) -> Result<f64> {
        let text = self.text(column)?;
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(self.error(column, "a finite number", text)),
        }
    }

    /// The field of a column as a whole number >= 0.
    ///
    /// # Errors
    /// [`Error::Parse`] where the column is missing or holds anything else.
    pub fn whole_number(&self, column: &str) -> Result<u32> {
        let text = self.text(column)?;
        text.parse().map_err(|_| self.error(column, "a whole number >= 0", text))
    }

    /// The field of a column as it stands.
    ///
    /// # Errors
    /// [`Error::Parse`] where the column is missing from this line.
    pub fn text(&self, column: &str) -> Result<&str> {
        self.optional_text(column)
            .ok_or_else(|| self.error(column, "a value", "the end of the line"))
    }

    /// The field of a column, or `None` where the line ends before it.
    pub fn optional_text(&self, column: &str) -> Option<&str> {
        let index = self.table.columns.iter().position(|name| name == column)?;
        self.fields.get(index).copied()
    }

    /// An error at a column of this line.
    pub fn error(&self, column: &str, expected: &str, found: &str) -> Error {
        self.table.error(self.line, column, expected, &format!("`{found}`"))
    }
}

/// The fields of a line: at commas where there is one, else at white space.
fn split(text: &str) -> Vec<&str> {
    if text.contains(',') {
        text.split(',').map(str::trim).collect()
    } else {
        text.split_whitespace().collect()
    }
}
