//! Text files line by line, gzipped or not.

use super::Words;
use crate::Result;
use flate2::bufread::MultiGzDecoder;
use loc_core::Error;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// Longest line of a log; a longer one is no message.
const LONGEST_LINE: u64 = 32 << 20;

/// Opens a text file, which is unpacked as it is read if it is gzipped.
///
/// # Errors
/// [`Error::Io`] where it cannot be opened.
pub fn open(file: &Path) -> Result<Box<dyn BufRead>> {
    let mut bytes = BufReader::new(File::open(file).map_err(Error::io(file))?);
    let gzipped = bytes.fill_buf().map_err(Error::io(file))?.starts_with(&[0x1f, 0x8b]);
    Ok(if gzipped { Box::new(BufReader::new(MultiGzDecoder::new(bytes))) } else { Box::new(bytes) })
}

/// The lines of a log, one at a time.
pub(in crate::source) struct LogLines {
    file: PathBuf,
    lines: Box<dyn BufRead>,
    number: usize,
    text: String,
}

impl LogLines {
    /// `file` is only named in errors.
    pub(in crate::source) fn new(file: impl Into<PathBuf>, lines: impl BufRead + 'static) -> Self {
        LogLines { file: file.into(), lines: Box::new(lines), number: 0, text: String::new() }
    }

    /// Reads the next line; false at the end.
    pub(in crate::source) fn advance(&mut self) -> Result<bool> {
        let mut bytes = Vec::new();
        self.number += 1;
        let read = self.lines.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut bytes);
        let count = read.map_err(Error::io(&self.file))?;
        // A host name may hold anything; the numbers are ASCII.
        self.text = String::from_utf8_lossy(&bytes).into_owned();
        Ok(count > 0)
    }

    /// The words of the line read last.
    pub(in crate::source) fn words(&self) -> Words<'_> {
        Words::new(&self.file, self.number, &self.text)
    }

    pub(in crate::source) fn file(&self) -> &Path {
        &self.file
    }
}

impl std::fmt::Debug for LogLines {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LogLines").field("file", &self.file).field("line", &self.number).finish()
    }
}
