//! Untrusted bytes: every length is checked against what is left.
//!
//! [`Input`] is a file, [`Fields`] a slice in memory.

use crate::{Error, Result};
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// The longest piece that is read into memory at once \[bytes\]; recorders write chunks of some
/// megabytes.
pub(crate) const MAX_BYTES: u64 = 1 << 30;

/// What a bag can be read from.
pub(crate) trait ReadSeek: Read + Seek {}
impl<T: Read + Seek> ReadSeek for T {}

/// A file with its length and the place that is read next.
pub(crate) struct Input {
    path: PathBuf,
    bytes: BufReader<Box<dyn ReadSeek>>,
    length: u64,
    position: u64,
}

impl Input {
    pub(crate) fn open(path: &Path) -> Result<Self> {
        let file = File::open(path).map_err(loc_core::Error::io(path))?;
        Input::new(path, file)
    }

    /// An input from anything that can be read; `path` is only named in errors.
    pub(crate) fn new(path: &Path, mut bytes: impl Read + Seek + 'static) -> Result<Self> {
        let length = bytes.seek(SeekFrom::End(0)).map_err(loc_core::Error::io(path))?;
        bytes.seek(SeekFrom::Start(0)).map_err(loc_core::Error::io(path))?;
        let bytes = BufReader::with_capacity(1 << 16, Box::new(bytes) as Box<dyn ReadSeek>);
        Ok(Input { path: path.to_owned(), bytes, length, position: 0 })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    pub(crate) fn position(&self) -> u64 {
        self.position
    }

    pub(crate) fn length(&self) -> u64 {
        self.length
    }

    pub(crate) fn left(&self) -> u64 {
        self.length.saturating_sub(self.position)
    }

    /// The share of the bytes that is read, in \[0, 1\].
    pub(crate) fn progress(&self) -> f64 {
        self.position as f64 / self.length.max(1) as f64
    }

    /// Reads `count` bytes, or what is left where that is less; the answer says how many.
    ///
    /// # Errors
    /// Where `count` is more than [`MAX_BYTES`], and what the operating system says.
    pub(crate) fn read(&mut self, what: &str, count: u64, into: &mut Vec<u8>) -> Result<usize> {
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

    /// Fills a slice, or its front where less is left; the answer says how much.
    pub(crate) fn fill(&mut self, into: &mut [u8]) -> Result<usize> {
        let mut count = 0;
        while let Some(rest) = into.get_mut(count..).filter(|rest| !rest.is_empty()) {
            match self.bytes.read(rest) {
                Ok(0) => break,
                Ok(read) => count += read,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(loc_core::Error::io(&self.path)(error).into()),
            }
        }
        self.position += count as u64;
        Ok(count)
    }

    /// Reads a few bytes; `None` where the file ends before.
    pub(crate) fn fixed<const N: usize>(&mut self) -> Result<Option<[u8; N]>> {
        let mut bytes = [0; N];
        if self.left() < N as u64 {
            return Ok(None);
        }
        self.bytes.read_exact(&mut bytes).map_err(loc_core::Error::io(&self.path))?;
        self.position += N as u64;
        Ok(Some(bytes))
    }

    /// Passes over bytes; false where the file ends before.
    pub(crate) fn skip(&mut self, count: u64) -> Result<bool> {
        let there = count <= self.left();
        let step = i64::try_from(count.min(self.left())).unwrap_or(i64::MAX);
        self.bytes.seek_relative(step).map_err(loc_core::Error::io(&self.path))?;
        self.position += count.min(self.left());
        Ok(there)
    }

    pub(crate) fn seek(&mut self, position: u64) -> Result<()> {
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
    pub(crate) fn error(&self, expected: impl Into<String>, found: impl Into<String>) -> Error {
        self.error_at(self.position, expected, found)
    }

    pub(crate) fn error_at(
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

/// Bytes that are taken from the front. Every answer is `None` where too few are left.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fields<'a> {
    bytes: &'a [u8],
}

impl<'a> Fields<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Fields { bytes }
    }

    pub(crate) fn len(&self) -> usize {
        self.bytes.len()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    pub(crate) fn take(&mut self, count: u64) -> Option<&'a [u8]> {
        let (front, rest) = self.bytes.split_at_checked(usize::try_from(count).ok()?)?;
        self.bytes = rest;
        Some(front)
    }

    pub(crate) fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N as u64)?.try_into().ok()
    }

    pub(crate) fn u8(&mut self) -> Option<u8> {
        self.array::<1>().map(|[byte]| byte)
    }

    pub(crate) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    /// Bytes behind their number as `u32`.
    pub(crate) fn block(&mut self) -> Option<&'a [u8]> {
        let count = self.u32()?;
        self.take(count.into())
    }

    /// A text behind its length as `u32`; what is no UTF-8 is replaced.
    pub(crate) fn text(&mut self) -> Option<String> {
        self.block().map(|bytes| String::from_utf8_lossy(bytes).into_owned())
    }
}
