//! Ctrl-C: nothing half is left behind, and the exit code says what happened.
//!
//! Results are written at the end of a run, whole or not at all; Ctrl-C in that moment waits until
//! they are. Before it, there is nothing to keep, so that the program ends at once and takes away
//! the file that it was about to fill.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Files that are not whole yet.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// From now on Ctrl-C ends the program so.
pub(super) fn watch() -> anyhow::Result<()> {
    ctrlc::set_handler(|| {
        // Held until the end: nobody begins to write any more.
        let files = unfinished();
        for file in files.iter() {
            let _ = std::fs::remove_file(file);
        }
        let _ = writeln!(std::io::stderr(), "\ninterrupted");
        std::process::exit(super::INTERRUPTED.into());
    })?;
    Ok(())
}

/// Does what must not be interrupted, and should be short.
pub(super) fn uninterrupted<T>(work: impl FnOnce() -> T) -> T {
    let _files = unfinished();
    work()
}

/// Lets `fill` write a file, which Ctrl-C takes away meanwhile.
pub(super) fn filling<T>(path: &Path, fill: impl FnOnce() -> T) -> T {
    // What is there already is a pipe or a device, which stays.
    let is_new = !path.exists();
    unfinished().extend(is_new.then(|| path.to_owned()));
    let filled = fill();
    unfinished().retain(|known| known != path);
    filled
}

/// A file that is taken away by Ctrl-C, and when this is dropped.
#[derive(Debug)]
pub(super) struct Unfinished {
    path: PathBuf,
}

impl Unfinished {
    pub(super) fn new(path: &Path) -> Self {
        unfinished().push(path.to_owned());
        Unfinished { path: path.to_owned() }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        unfinished().retain(|path| *path != self.path);
        // It is not there any more where it has taken its place.
        let _ = std::fs::remove_file(&self.path);
    }
}
