//! Line maps as text.

use super::{LineMap, LineSegment};
use crate::bounds::column;
use crate::{Error, Result};
use loc_core::table::{Row, Table};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const COLUMNS: [&str; 4] = ["x1", "y1", "x2", "y2"];

impl LineMap {
    /// Reads a text file with the columns `x1,y1,x2,y2` \[m\], at commas or white space.
    ///
    /// # Errors
    /// [`loc_core::Error`] for files that cannot be read, with line and column for what cannot be
    /// understood and for a line without length, and for a file without lines.
    pub fn read_csv(file: impl AsRef<Path>) -> Result<Self> {
        LineMap::from_table(&Table::read(file, &COLUMNS)?)
    }

    /// The same from a text; `file` is only named in errors.
    ///
    /// # Errors
    /// As [`LineMap::read_csv`].
    pub fn parse_csv(file: impl Into<PathBuf>, text: &str) -> Result<Self> {
        LineMap::from_table(&Table::parse(file, text, &COLUMNS))
    }

    /// The map as the text of a CSV file, every number to its last digit.
    pub fn to_csv(&self) -> String {
        let mut text = COLUMNS.join(",") + "\n";
        for LineSegment { start, end } in self.lines() {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{},{},{},{}", start.x, start.y, end.x, end.y);
        }
        text
    }

    fn from_table(table: &Table) -> Result<Self> {
        let lines: Vec<LineSegment> =
            table.rows().map(|row| from_row(&row?)).collect::<loc_core::Result<_>>()?;
        if lines.is_empty() {
            let file = table.file().to_owned();
            return Err(Error::Core(loc_core::Error::Empty { file, what: "lines" }));
        }
        LineMap::new(lines)
    }
}

fn from_row(row: &Row<'_>) -> loc_core::Result<LineSegment> {
    let [x1, y1, x2, y2] = COLUMNS.map(|name| column(row, name));
    let line = LineSegment::new([x1?, y1?], [x2?, y2?]);
    if line.has_length() {
        return Ok(line);
    }
    let [_, _, x2, y2] = COLUMNS.map(|name| row.optional_text(name).unwrap_or_default());
    Err(row.error("x2,y2", "another point than x1,y1", &format!("{x2},{y2}")))
}
