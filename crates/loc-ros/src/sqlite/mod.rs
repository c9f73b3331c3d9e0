//! Tables of a SQLite file, read from front to back (<https://www.sqlite.org/fileformat2.html>).
//!
//! A bag of ROS 2 in the format `sqlite3` is a database with two tables. To read them one needs a
//! small part of SQLite: pages ([`pages`]), the tree of a table with its records ([`rows`]), and
//! the pages that a write-ahead log (`-wal`) has in place of the file's.

mod pages;
mod rows;

pub(crate) use rows::{Row, TableScan, Value};

use crate::Result;
use crate::bytes::Input;
use pages::Pager;
use std::io::{Read, Seek};
use std::path::Path;

/// What a SQLite file starts with.
pub(crate) const MAGIC: &[u8; 16] = b"SQLite format 3\0";

/// The page at which the table of tables starts.
const ROOT: u32 = 1;

/// A SQLite file.
#[derive(Debug)]
pub(crate) struct Database {
    pager: Pager,
}

/// A table: where its tree starts, and its columns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Table {
    root: u32,
    columns: Vec<String>,
    /// The column that is the number of the row, where there is one.
    row_id: Option<usize>,
}

impl Database {
    pub(crate) fn open(path: &Path) -> Result<Self> {
        let mut log = path.as_os_str().to_owned();
        log.push("-wal");
        let log = Path::new(&log);
        let log = log.exists().then(|| Input::open(log)).transpose()?;
        Ok(Database { pager: Pager::new(Input::open(path)?, log)? })
    }

    /// A database from anything that can be read; `path` is only named in errors.
    pub(crate) fn read(path: &Path, bytes: impl Read + Seek + 'static) -> Result<Self> {
        Ok(Database { pager: Pager::new(Input::new(path, bytes)?, None)? })
    }

    pub(crate) fn path(&self) -> &Path {
        self.pager.path()
    }

    /// The share of the file's pages that were read, in \[0, 1\].
    pub(crate) fn progress(&self) -> f64 {
        self.pager.progress()
    }

    /// Whether a page was asked for that the file does not have.
    pub(crate) fn breaks_off(&self) -> Option<u32> {
        self.pager.missing()
    }

    /// The table of a name.
    pub(crate) fn table(&mut self, name: &str) -> Result<Option<Table>> {
        let mut scan = TableScan::new(ROOT);
        while let Some(row) = scan.next(&mut self.pager)? {
            if let Some(table) = table_of(&row, name) {
                return Ok(Some(table));
            }
        }
        Ok(None)
    }

    /// The next row of a table.
    pub(crate) fn next(&mut self, scan: &mut TableScan) -> Result<Option<Row>> {
        scan.next(&mut self.pager)
    }

    pub(crate) fn error(&self, expected: &str, found: impl Into<String>) -> crate::Error {
        self.pager.error(expected, found)
    }
}

impl Table {
    pub(crate) fn scan(&self) -> TableScan {
        TableScan::new(self.root)
    }

    /// Index of a column.
    pub(crate) fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }

    /// A value of a row, by the index of its column.
    pub(crate) fn value<'r>(&self, row: &'r Row, column: usize) -> Value<'r> {
        match row.value(column) {
            Value::Null if self.row_id == Some(column) => Value::Integer(row.id),
            value => value,
        }
    }
}

/// The table of a name, where a row of the table of tables (type, name, table, root, SQL) is it.
fn table_of(row: &Row, name: &str) -> Option<Table> {
    let text = |column| match row.value(column) {
        Value::Text(text) => Some(String::from_utf8_lossy(text).into_owned()),
        _ => None,
    };
    if text(0)? != "table" || text(1)? != name {
        return None;
    }
    let Value::Integer(root) = row.value(3) else { return None };
    let definitions = definitions(&text(4)?);
    let is_row_id = |words: &Vec<String>| {
        let tail: Vec<String> = words.iter().skip(1).map(|w| w.to_uppercase()).collect();
        tail.starts_with(&["INTEGER".into(), "PRIMARY".into(), "KEY".into()])
    };
    Some(Table {
        root: u32::try_from(root).ok()?,
        row_id: definitions.iter().position(is_row_id),
        columns: definitions.into_iter().filter_map(|words| words.into_iter().next()).collect(),
    })
}

/// The words of each column of `CREATE TABLE name(column, column, ..)`.
fn definitions(sql: &str) -> Vec<Vec<String>> {
    let inside = sql.split_once('(').map_or("", |(_, rest)| rest);
    let inside = inside.rsplit_once(')').map_or(inside, |(inside, _)| inside);
    let (mut columns, mut column, mut depth) = (Vec::new(), String::new(), 0_u32);
    for letter in inside.chars() {
        match letter {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if letter == ',' && depth == 0 {
            columns.push(std::mem::take(&mut column));
        } else {
            column.push(letter);
        }
    }
    columns.push(column);
    let quotes: &[char] = &['"', '`', '[', ']'];
    let words = |column: String| {
        column.split_whitespace().map(|word| word.trim_matches(quotes).to_owned()).collect()
    };
    columns.into_iter().map(words).collect()
}
