//! The words of one line, with errors that say where.

use crate::{Error, Result};
use loc_core::Pose2;
use std::path::Path;
use std::str::SplitAsciiWhitespace;

/// Takes the words of a message one after the other.
pub(in crate::source) struct Words<'a> {
    file: &'a Path,
    line: usize,
    words: SplitAsciiWhitespace<'a>,
}

impl<'a> Words<'a> {
    pub(in crate::source) fn new(file: &'a Path, line: usize, text: &'a str) -> Self {
        Words { file, line, words: text.split_ascii_whitespace() }
    }

    pub(in crate::source) fn word(&mut self, field: &str) -> Result<&'a str> {
        self.words.next().ok_or_else(|| self.error(field, "a value", "the end of the line"))
    }

    /// A finite number.
    pub(in crate::source) fn number(&mut self, field: &str) -> Result<f64> {
        let word = self.word(field)?;
        let number = word.parse::<f64>().ok().filter(|value| value.is_finite());
        number.ok_or_else(|| self.error(field, "a finite number", &format!("`{word}`")))
    }

    /// A number of values that follow, at most `most`.
    pub(in crate::source) fn count(&mut self, field: &str, most: usize) -> Result<usize> {
        let word = self.word(field)?;
        let count = word.parse::<usize>().ok().filter(|count| *count <= most);
        let expected = format!("a whole number up to {most}");
        count.ok_or_else(|| self.error(field, &expected, &format!("`{word}`")))
    }

    pub(in crate::source) fn numbers(&mut self, field: &str, count: usize) -> Result<Vec<f64>> {
        (0..count).map(|_| self.number(field)).collect()
    }

    pub(in crate::source) fn pose(&mut self, field: &str) -> Result<Pose2> {
        Ok(Pose2::new(self.number(field)?, self.number(field)?, self.number(field)?))
    }

    pub(in crate::source) fn skip(&mut self, field: &str, count: usize) -> Result<()> {
        (0..count).try_for_each(|_| self.word(field).map(|_| ()))
    }

    /// Nothing more may stand on the line.
    pub(in crate::source) fn end(&mut self) -> Result<()> {
        match self.words.next() {
            None => Ok(()),
            Some(word) => Err(self.error("line", "the end of the line", &format!("`{word}`"))),
        }
    }

    pub(in crate::source) fn error(&self, field: &str, expected: &str, found: &str) -> Error {
        Error::Core(loc_core::Error::Parse {
            file: self.file.to_owned(),
            line: self.line,
            field: field.to_owned(),
            expected: expected.to_owned(),
            found: found.to_owned(),
        })
    }
}
