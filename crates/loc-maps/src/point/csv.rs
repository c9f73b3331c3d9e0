//! Point maps as text.

use super::PointMap;
use crate::bounds::column;
use crate::{Error, Result};
use loc_core::table::Table;
use nalgebra::Point2;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const COLUMNS: [&str; 2] = ["x", "y"];

impl PointMap {
    /// Reads a text file with the columns `x,y` \[m\], at commas or white space.
    ///
    /// # Errors
    /// [`loc_core::Error`] for files that cannot be read, with line and column for what cannot be
    /// understood, and for a file without points.
    pub fn read_csv(file: impl AsRef<Path>) -> Result<Self> {
        PointMap::from_table(&Table::read(file, &COLUMNS)?)
    }

    /// The same from a text; `file` is only named in errors.
    ///
    /// # Errors
    /// As [`PointMap::read_csv`].
    pub fn parse_csv(file: impl Into<PathBuf>, text: &str) -> Result<Self> {
        PointMap::from_table(&Table::parse(file, text, &COLUMNS))
    }

    /// The points as the text of a CSV file, every number to its last digit.
    pub fn to_csv(&self) -> String {
        let mut text = COLUMNS.join(",") + "\n";
        for point in self.points() {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{},{}", point.x, point.y);
        }
        text
    }

    fn from_table(table: &Table) -> Result<Self> {
        let mut points = Vec::new();
        for row in table.rows() {
            let row = row?;
            points.push(Point2::new(column(&row, "x")?, column(&row, "y")?));
        }
        if points.is_empty() {
            let file = table.file().to_owned();
            return Err(Error::Core(loc_core::Error::Empty { file, what: "points" }));
        }
        PointMap::new(points)
    }
}
