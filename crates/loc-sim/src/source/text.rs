//! Reading text recordings: lines, gzipped or not, their words, and fields of tables, with errors
//! that name file, line and field.

use crate::{Error, Result};
use flate2::bufread::MultiGzDecoder;
use loc_core::Pose2;
use loc_core::table::Row;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::str::SplitAsciiWhitespace;

/// Longest line of a log \[bytes\]; a longer one is cut.
const LONGEST_LINE: u64 = 32 << 20;

/// Opens a text file, which is unpacked as it is read if it is gzipped.
///
/// # Errors
/// [`loc_core::Error::Io`] where it cannot be opened.
pub fn open(file: &Path) -> Result<Box<dyn BufRead>> {
    let mut bytes = BufReader::new(File::open(file).map_err(loc_core::Error::io(file))?);
    let gzipped = bytes.fill_buf().map_err(loc_core::Error::io(file))?.starts_with(&[0x1f, 0x8b]);
    Ok(if gzipped { Box::new(BufReader::new(MultiGzDecoder::new(bytes))) } else { Box::new(bytes) })
}

/// The lines of a log, one at a time.
pub(super) struct LogLines {
    file: PathBuf,
    lines: Box<dyn BufRead>,
    number: usize,
    text: String,
}

impl LogLines {
    /// `file` is only named in errors.
    pub(super) fn new(file: impl Into<PathBuf>, lines: impl BufRead + 'static) -> Self {
        LogLines { file: file.into(), lines: Box::new(lines), number: 0, text: String::new() }
    }

    /// Reads the next line; false at the end.
    pub(super) fn advance(&mut self) -> Result<bool> {
        let mut bytes = Vec::new();
        self.number += 1;
        let read = self.lines.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut bytes);
        let count = read.map_err(loc_core::Error::io(&self.file))?;
        // A host name may hold anything; the numbers are ASCII.
        self.text = String::from_utf8_lossy(&bytes).into_owned();
        Ok(count > 0)
    }

    /// The words of the line read last.
    pub(super) fn words(&self) -> Words<'_> {
        Words::new(&self.file, self.number, &self.text)
    }

    pub(super) fn file(&self) -> &Path {
        &self.file
    }
}

impl std::fmt::Debug for LogLines {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LogLines").field("file", &self.file).field("line", &self.number).finish()
    }
}

/// The words of one line, read one after the other, with errors that name file, line and field.
pub(super) struct Words<'a> {
    file: &'a Path,
    line: usize,
    words: SplitAsciiWhitespace<'a>,
}

impl<'a> Words<'a> {
    pub(super) fn new(file: &'a Path, line: usize, text: &'a str) -> Self {
        Words { file, line, words: text.split_ascii_whitespace() }
    }

    pub(super) fn word(&mut self, field: &str) -> Result<&'a str> {
        self.words.next().ok_or_else(|| self.error(field, "a value", "the end of the line"))
    }

    /// A finite number.
    pub(super) fn number(&mut self, field: &str) -> Result<f64> {
        let word = self.word(field)?;
        let number = word.parse::<f64>().ok().filter(|value| value.is_finite());
        number.ok_or_else(|| self.error(field, "a finite number", &format!("`{word}`")))
    }

    /// The number of values that follow, at most `max`.
    pub(super) fn count(&mut self, field: &str, max: usize) -> Result<usize> {
        let word = self.word(field)?;
        let count = word.parse::<usize>().ok().filter(|count| *count <= max);
        let expected = format!("a whole number up to {max}");
        count.ok_or_else(|| self.error(field, &expected, &format!("`{word}`")))
    }

    pub(super) fn numbers(&mut self, field: &str, count: usize) -> Result<Vec<f64>> {
        (0..count).map(|_| self.number(field)).collect()
    }

    pub(super) fn pose(&mut self, field: &str) -> Result<Pose2> {
        Ok(Pose2::new(self.number(field)?, self.number(field)?, self.number(field)?))
    }

    pub(super) fn skip(&mut self, field: &str, count: usize) -> Result<()> {
        (0..count).try_for_each(|_| self.word(field).map(|_| ()))
    }

    /// Refuses further words on the line.
    pub(super) fn end(&mut self) -> Result<()> {
        match self.words.next() {
            None => Ok(()),
            Some(word) => Err(self.error("line", "the end of the line", &format!("`{word}`"))),
        }
    }

    pub(super) fn error(&self, field: &str, expected: &str, found: &str) -> Error {
        Error::Core(loc_core::Error::Parse {
            file: self.file.to_owned(),
            line: self.line,
            field: field.to_owned(),
            expected: expected.to_owned(),
            found: found.to_owned(),
        })
    }
}

/// A whole number in a column, also if written with decimals: `6.000000`.
pub(super) fn whole(row: &Row<'_>, column: &str) -> Result<u32> {
    let value = row.number(column)?;
    if value >= 0.0 && value.fract() == 0.0 && value <= f64::from(u32::MAX) {
        // A whole number in range.
        return Ok(value as u32);
    }
    Err(row.error(column, "a whole number >= 0", row.text(column)?).into())
}

/// A distance >= 0 in a column.
pub(super) fn distance(row: &Row<'_>, column: &str) -> Result<f64> {
    let value = row.number(column)?;
    if value >= 0.0 {
        return Ok(value);
    }
    Err(row.error(column, "a distance >= 0", row.text(column)?).into())
}

/// A stamp that must not be before that of the row above.
pub(super) fn stamp_after(row: &Row<'_>, column: &str, last: &mut f64) -> Result<f64> {
    let stamp = row.number(column)?;
    if stamp < *last {
        let expected = format!("a time not before {last}, that of the line above");
        return Err(row.error(column, &expected, row.text(column)?).into());
    }
    *last = stamp;
    Ok(stamp)
}

/// Refuses a file without data.
pub(super) fn not_empty(empty: bool, file: &Path, what: &'static str) -> Result<()> {
    if empty {
        return Err(loc_core::Error::Empty { file: file.to_owned(), what }.into());
    }
    Ok(())
}
