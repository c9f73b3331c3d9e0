//! Writing files so that a reader never meets half of one.

use crate::{Error, Result};
use std::fs;
use std::path::Path;

/// Writes a file whole or not at all: into a neighbour first, which then takes its place.
///
/// # Errors
/// [`Error::Io`] with the path; what stood there before is left as it was.
pub fn write_whole(path: impl AsRef<Path>, contents: impl AsRef<[u8]>) -> Result<()> {
    let path = path.as_ref();
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.part", std::process::id()));
    let part = path.with_file_name(name);
    let written = fs::write(&part, contents).and_then(|()| fs::rename(&part, path));
    written.map_err(|source| {
        // The neighbour may not even exist; the first error is the one to tell.
        let _ = fs::remove_file(&part);
        Error::Io { path: path.to_owned(), source }
    })
}
