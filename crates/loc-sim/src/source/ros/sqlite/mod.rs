//! Tables of a SQLite file, read from front to back (<https://www.sqlite.org/fileformat2.html>).
//!
//! A bag of ROS 2 in the format `sqlite3` is a database with two tables. To read them one needs a
//! small part of SQLite: pages, the tree of a table, records, and the pages that a write-ahead log
//! (`-wal`) has in place of the file's.

mod pager;
mod scan;
mod schema;
mod value;
mod wal;

pub(super) use scan::TableScan;
pub(super) use value::{Row, Value};

use super::input::Input;
use crate::Result;
use pager::Pager;
use std::io::{Read, Seek};
use std::path::Path;

/// What a SQLite file starts with.
pub(super) const MAGIC: &[u8; 16] = b"SQLite format 3\0";

/// A SQLite file.
#[derive(Debug)]
pub(super) struct Database {
    pager: Pager,
}

/// A table: where its tree starts, and its columns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Table {
    root: u32,
    columns: Vec<String>,
    /// The column that is the number of the row, where there is one.
    row_id: Option<usize>,
}

impl Database {
    pub(super) fn open(path: &Path) -> Result<Self> {
        let mut log = path.as_os_str().to_owned();
        log.push("-wal");
        let log = Path::new(&log);
        let log = log.exists().then(|| Input::open(log)).transpose()?;
        Ok(Database { pager: Pager::new(Input::open(path)?, log)? })
    }

    /// A database from anything that can be read; `path` is only named in errors.
    pub(super) fn read(path: &Path, bytes: impl Read + Seek + 'static) -> Result<Self> {
        Ok(Database { pager: Pager::new(Input::new(path, bytes)?, None)? })
    }

    pub(super) fn path(&self) -> &Path {
        self.pager.path()
    }

    /// The share of the file's pages that were read, in \[0, 1\].
    pub(super) fn progress(&self) -> f64 {
        self.pager.progress()
    }

    /// Whether a page was asked for that the file does not have.
    pub(super) fn breaks_off(&self) -> Option<u32> {
        self.pager.missing()
    }

    /// The table of a name.
    pub(super) fn table(&mut self, name: &str) -> Result<Option<Table>> {
        let mut scan = TableScan::new(schema::ROOT);
        while let Some(row) = scan.next(&mut self.pager)? {
            if let Some(table) = schema::table(&row, name) {
                return Ok(Some(table));
            }
        }
        Ok(None)
    }

    /// The next row of a table.
    pub(super) fn next(&mut self, scan: &mut TableScan) -> Result<Option<Row>> {
        scan.next(&mut self.pager)
    }

    pub(super) fn error(&self, expected: &str, found: impl Into<String>) -> crate::Error {
        self.pager.error(expected, found)
    }
}

impl Table {
    pub(super) fn scan(&self) -> TableScan {
        TableScan::new(self.root)
    }

    /// Index of a column.
    pub(super) fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }

    /// A value of a row, by the index of its column.
    pub(super) fn value<'r>(&self, row: &'r Row, column: usize) -> Value<'r> {
        match row.value(column) {
            Value::Null if self.row_id == Some(column) => Value::Integer(row.id),
            value => value,
        }
    }
}
