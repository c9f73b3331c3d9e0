//! Atomic writing of files: a reader never sees a partial one.

use crate::{Error, Result};
use std::fs;
use std::path::Path;

/// Writes a file atomically: into a temporary file beside it, which is then renamed.
///
/// # Errors
/// [`Error::Io`] with the path; an existing file is then unchanged.
pub fn write_whole(path: impl AsRef<Path>, contents: impl AsRef<[u8]>) -> Result<()> {
    let path = path.as_ref();
    write_beside(path, |part| {
        fs::write(part, contents).map_err(|source| Error::Io { path: path.to_owned(), source })
    })
}

/// Lets `write` fill a temporary file beside `path`, which is renamed to `path` on success: a
/// reader never sees a partial file. A pipe or a device is written directly.
///
/// # Errors
/// Those of `write`, and [`Error::Io`]; the file is then as it was.
pub fn write_beside<T, E: From<Error>>(
    path: impl AsRef<Path>,
    write: impl FnOnce(&Path) -> std::result::Result<T, E>,
) -> std::result::Result<T, E> {
    let path = path.as_ref();
    if fs::metadata(path).is_ok_and(|there| !there.is_file()) {
        return write(path);
    }
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.part", std::process::id()));
    let part = path.with_file_name(name);
    let written = write(&part).and_then(|value| {
        fs::rename(&part, path).map_err(|source| Error::Io { path: path.to_owned(), source })?;
        Ok(value)
    });
    if written.is_err() {
        // The temporary file may not exist; the first error is the one to report.
        let _ = fs::remove_file(&part);
    }
    written
}

/// Makes a folder, with those above it, and lets `fill` write into it. Where that fails, folders
/// that were made for it and are empty are removed again.
///
/// # Errors
/// Those of `fill`, and [`Error::Io`] for a folder that cannot be made.
pub fn in_folder<T, E: From<Error>>(
    path: impl AsRef<Path>,
    fill: impl FnOnce(&Path) -> std::result::Result<T, E>,
) -> std::result::Result<T, E> {
    let path = path.as_ref();
    let is_new = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
    let made: Vec<&Path> = path.ancestors().take_while(is_new).collect();
    let filled = fs::create_dir_all(path).map_err(|e| Error::io(path)(e).into());
    let filled = filled.and_then(|()| fill(path));
    if filled.is_err() {
        // The deepest first; a folder that holds something stays.
        made.iter().for_each(|folder| drop(fs::remove_dir(folder)));
    }
    filled
}
