//! A file of which nothing is believed: every length is held against what is left of it.

use crate::{Error, Result};
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// The longest piece that is read into memory at once \[bytes\]; recorders write chunks of some
/// megabytes.
pub(super) const MAX_BYTES: u64 = 1 << 30;

/// What a bag can be read from.
pub(super) trait ReadSeek: Read + Seek {}
impl<T: Read + Seek> ReadSeek for T {}

/// A file with its length and the place that is read next.
pub(super) struct Input {
    path: PathBuf,
    bytes: BufReader<Box<dyn ReadSeek>>,
    length: u64,
    position: u64,
}

impl Input {
    pub(super) fn open(path: &Path) -> Result<Self> {
        let file = File::open(path).map_err(loc_core::Error::io(path))?;
        Input::new(path, file)
    }

    /// An input from anything that can be read; `path` is only named in errors.
    pub(super) fn new(path: &Path, mut bytes: impl Read + Seek + 'static) -> Result<Self> {
        let length = bytes.seek(SeekFrom::End(0)).map_err(loc_core::Error::io(path))?;
        bytes.seek(SeekFrom::Start(0)).map_err(loc_core::Error::io(path))?;
        let bytes = BufReader::with_capacity(1 << 16, Box::new(bytes) as Box<dyn ReadSeek>);
        Ok(Input { path: path.to_owned(), bytes, length, position: 0 })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn position(&self) -> u64 {
        self.position
    }

    pub(super) fn length(&self) -> u64 {
        self.length
    }

    pub(super) fn left(&self) -> u64 {
        self.length.saturating_sub(self.position)
    }

    /// The share of the bytes that is read, in \[0, 1\].
    pub(super) fn progress(&self) -> f64 {
        self.position as f64 / self.length.max(1) as f64
    }

    /// Reads `count` bytes, or what is left where that is less; the answer says how many.
    ///
    /// # Errors
    /// Where `count` is more than [`MAX_BYTES`], and what the operating system says.
    pub(super) fn read(&mut self, what: &str, count: u64, into: &mut Vec<u8>) -> Result<usize> {
        if count > MAX_BYTES {
            let found = format!("a length of {count} bytes");
            return Err(self.error(format!("{what} of at most {MAX_BYTES} bytes"), found));
        }
        let count = usize::try_from(count.min(self.left())).unwrap_or(usize::MAX);
        into.resize(count, 0);
        match self.bytes.read_exact(into) {
            Ok(()) => {}
            // A file that becomes shorter while it is read breaks off here.
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => {
                into.clear();
                self.length = self.position;
            }
            Err(error) => return Err(loc_core::Error::io(&self.path)(error).into()),
        }
        self.position += into.len() as u64;
        Ok(into.len())
    }

    /// Reads a few bytes; `None` where the file ends before.
    pub(super) fn fixed<const N: usize>(&mut self) -> Result<Option<[u8; N]>> {
        let mut bytes = [0; N];
        if self.left() < N as u64 {
            return Ok(None);
        }
        self.bytes.read_exact(&mut bytes).map_err(loc_core::Error::io(&self.path))?;
        self.position += N as u64;
        Ok(Some(bytes))
    }

    /// Passes over bytes; false where the file ends before.
    pub(super) fn skip(&mut self, count: u64) -> Result<bool> {
        let there = count <= self.left();
        let step = i64::try_from(count.min(self.left())).unwrap_or(i64::MAX);
        self.bytes.seek_relative(step).map_err(loc_core::Error::io(&self.path))?;
        self.position += count.min(self.left());
        Ok(there)
    }

    pub(super) fn seek(&mut self, position: u64) -> Result<()> {
        let ahead = i64::try_from(position).ok().zip(i64::try_from(self.position).ok());
        match ahead {
            Some((to, from)) => self.bytes.seek_relative(to - from),
            None => self.bytes.seek(SeekFrom::Start(position)).map(|_| ()),
        }
        .map_err(loc_core::Error::io(&self.path))?;
        self.position = position;
        Ok(())
    }

    /// An error at the byte that would be read next.
    pub(super) fn error(&self, expected: impl Into<String>, found: impl Into<String>) -> Error {
        self.error_at(self.position, expected, found)
    }

    pub(super) fn error_at(
        &self,
        position: u64,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> Error {
        Error::Recording {
            path: self.path.clone(),
            expected: format!("at byte {position} {}", expected.into()),
            found: found.into(),
        }
    }
}

impl std::fmt::Debug for Input {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Input").field("path", &self.path).field("position", &self.position).finish()
    }
}
