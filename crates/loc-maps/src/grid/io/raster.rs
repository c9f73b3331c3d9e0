//! A grey image in memory, whatever file it came from.

use super::{pgm, picture, wrong};
use crate::grid::MAX_CELLS;
use crate::{Error, Result};
use std::path::Path;

/// How much larger than its file an image can be: deflate gives at most 1032 bytes for one.
const LARGEST_EXPANSION: usize = 1032;

/// Grey values, the top row first.
#[derive(Debug)]
pub(super) struct Raster {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) samples: Samples,
    /// The sample that means white.
    pub(super) white: u16,
    /// Whether each pixel is opaque; `None` where all are.
    pub(super) opaque: Option<Vec<bool>>,
}

/// The samples, in as few bytes as they need.
#[derive(Debug)]
pub(super) enum Samples {
    Bytes(Vec<u8>),
    Words(Vec<u16>),
}

impl Raster {
    /// Decodes the bytes of a file; what it is, is read off its beginning, not off its name.
    pub(super) fn decode(file: &Path, bytes: Vec<u8>) -> Result<Self> {
        match bytes.get(..2) {
            Some(b"P2" | b"P5") => pgm::decode(file, bytes),
            _ => picture::decode(file, &bytes),
        }
    }
}

/// Refuses sizes that cannot be a map or that `bytes` bytes of file cannot fill.
pub(super) fn check_size(file: &Path, width: u64, height: u64, bytes: usize) -> Result<()> {
    let pixels = width.saturating_mul(height);
    let found = format!("{width} x {height}");
    if pixels == 0 || pixels > MAX_CELLS as u64 {
        return Err(wrong(file, "image size", "1 to 2^28 pixels", &found));
    }
    // One bit is the least that a pixel takes.
    if pixels / 8 > bytes.saturating_mul(LARGEST_EXPANSION) as u64 {
        return Err(too_short(file, &format!("the pixels of {found}"), bytes));
    }
    Ok(())
}

/// A file that ends before its pixels do.
pub(super) fn too_short(file: &Path, expected: &str, bytes: usize) -> Error {
    wrong(file, "pixels", expected, &format!("a file of {bytes} bytes"))
}
