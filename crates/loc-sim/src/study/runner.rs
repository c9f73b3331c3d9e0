//! Runs what is missing, on several threads.

use super::journal::Journal;
use super::{Grid, Job, RunOutcome};
use crate::{Error, Result};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

/// How often the caller is asked whether to go on, where no run ends meanwhile.
const PATIENCE: Duration = Duration::from_millis(50);

/// How far a study is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StudyProgress {
    /// Runs that an earlier start has done.
    pub kept: usize,
    /// Runs that are done.
    pub done: usize,
    /// All runs.
    pub total: usize,
}

/// Does the runs that the journal lacks and puts each into it. `tell` is told how far it is, and
/// answers whether to go on; runs that have begun are finished in any case. The answer is whether
/// all are done.
///
/// The threads take the runs in the order of the grid; each run depends on its setting and its
/// seed alone, so neither the number of threads nor an interruption can change it.
pub(super) fn complete(
    grid: &Grid,
    journal: &mut Journal,
    threads: usize,
    run: &(dyn Fn(Job) -> Result<RunOutcome> + Sync),
    tell: &mut dyn FnMut(StudyProgress) -> bool,
) -> Result<bool> {
    let missing: Vec<usize> = (0..grid.len()).filter(|&index| !journal.has(index)).collect();
    let (kept, total) = (journal.kept(), grid.len());
    let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let mut first_error: Option<Error> = None;
    std::thread::scope(|scope| {
        let (sender, outcomes) = mpsc::channel();
        for _ in 0..threads.clamp(1, missing.len().max(1)) {
            let sender = sender.clone();
            let (missing, next, stop) = (&missing, &next, &stop);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) {
                    let Some(&index) = missing.get(next.fetch_add(1, Ordering::Relaxed)) else {
                        break;
                    };
                    if sender.send(run(grid.job(index))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        loop {
            let done = match outcomes.recv_timeout(PATIENCE) {
                Ok(outcome) => outcome.and_then(|outcome| journal.add(grid, &outcome)),
                Err(RecvTimeoutError::Timeout) => Ok(()),
                Err(RecvTimeoutError::Disconnected) => break,
            };
            if let Err(error) = done {
                stop.store(true, Ordering::Relaxed);
                // The first one is the cause of the others.
                first_error.get_or_insert(error);
            }
            if !tell(StudyProgress { kept, done: journal.kept(), total }) {
                stop.store(true, Ordering::Relaxed);
            }
        }
    });
    let synced = journal.sync();
    match first_error {
        Some(error) => Err(error),
        None => synced.map(|()| journal.kept() == total),
    }
}
