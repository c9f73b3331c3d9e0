//! The journal of a study: the file of its finished runs, so that an interruption loses none.
//!
//! The first line identifies the study, each further line is one finished run, as JSON. Lines are
//! only appended, each in one write. If the program ends at any time (a signal, a full disk, power
//! loss), at most the last line is incomplete, and the next start removes it; an incomplete line
//! anywhere else is an error. A lock excludes a second study from the file.

use super::{Grid, Job, RunOutcome};
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The name of the file.
pub const FILE: &str = "journal.jsonl";

/// How every journal begins.
const HEAD: &[u8] = b"{\"journal\":";

/// How often a lock is tried again.
const PATIENCE: u32 = 15;

/// Period of flushing the file to the disk, against power loss.
const SYNC_EVERY: Duration = Duration::from_secs(1);

/// What a study is: everything that its runs depend on, but for the seed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fingerprint {
    /// The form of the journal.
    pub journal: u32,
    /// The program that runs it: version and build.
    pub program: String,
    /// The scenario with its changes, a setting per entry.
    pub scenario: Vec<String>,
    /// The settings that are varied, with their values.
    pub vary: Vec<String>,
    /// The methods.
    pub methods: Vec<String>,
    /// How estimates are aligned.
    pub align: String,
}

/// An open journal.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    /// Where the line of each run of the grid begins.
    places: Vec<Option<u64>>,
    kept: usize,
    end: u64,
    synced: Instant,
}

impl Journal {
    /// Opens the journal of a study in a folder, or begins one.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`]; [`Error::OtherStudy`] for the journal of another study,
    /// [`Error::Busy`] where that is running, [`Error::Recording`] for a file that is no journal.
    pub fn open(folder: &Path, fingerprint: &Fingerprint, grid: &Grid) -> Result<Self> {
        loc_core::file::in_folder(folder, |folder| Journal::open_in(folder, fingerprint, grid))
    }

    fn open_in(folder: &Path, fingerprint: &Fingerprint, grid: &Grid) -> Result<Self> {
        let path = folder.join(FILE);
        let is_new = !path.exists();
        let mut options = OpenOptions::new();
        let file = options.read(true).append(true).create(true).open(&path);
        let file = file.map_err(loc_core::Error::io(&path))?;
        lock(&file).map_err(|_| Error::Busy { path: path.clone() })?;
        let places = vec![None; grid.len()];
        let mut journal = Journal { path, file, places, kept: 0, end: 0, synced: Instant::now() };
        journal.read(fingerprint, grid)?;
        if journal.end == 0 {
            let begun = line(fingerprint).and_then(|line| journal.append(&line));
            if begun.is_err() && is_new {
                // Not even the first line: there is nothing to go on with.
                let _ = std::fs::remove_file(&journal.path);
            }
            begun?;
        }
        Ok(journal)
    }

    /// Reads what is there, and takes a torn last line off.
    fn read(&mut self, fingerprint: &Fingerprint, grid: &Grid) -> Result<()> {
        let io = || loc_core::Error::io(self.path.clone());
        self.file.seek(SeekFrom::Start(0)).map_err(io())?;
        let mut reader = BufReader::new(&self.file);
        let mut bytes = Vec::new();
        let mut number = 0_usize;
        loop {
            bytes.clear();
            let length = reader.read_until(b'\n', &mut bytes).map_err(io())?;
            if length == 0 || bytes.last() != Some(&b'\n') {
                // A file of another program is not truncated.
                if number == 0 && !HEAD.starts_with(&bytes) && !bytes.starts_with(HEAD) {
                    return Err(no_journal(&self.path));
                }
                break;
            }
            number += 1;
            if number == 1 {
                check(&self.path, &bytes, fingerprint)?;
            } else {
                match serde_json::from_slice::<RunOutcome>(&bytes) {
                    Ok(outcome) => self.kept += keep(&mut self.places, grid, &outcome, self.end),
                    // A loss of power can leave a line of anything, but only the last one.
                    Err(_) if is_end(&mut reader) => break,
                    Err(error) => return Err(damaged(&self.path, number, &error)),
                }
            }
            self.end += length as u64;
        }
        drop(reader);
        if self.file.metadata().map_err(io())?.len() != self.end {
            self.file.set_len(self.end).map_err(io())?;
        }
        Ok(())
    }

    /// Adds a finished run.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`]: what was kept before is still kept.
    pub fn add(&mut self, grid: &Grid, outcome: &RunOutcome) -> Result<()> {
        let place = self.end;
        self.append(&line(outcome)?)?;
        self.kept += keep(&mut self.places, grid, outcome, place);
        if self.synced.elapsed() > SYNC_EVERY {
            self.sync()?;
        }
        Ok(())
    }

    fn append(&mut self, line: &[u8]) -> Result<()> {
        if let Err(error) = self.file.write_all(line) {
            // Half a line would be taken off at the next start; now is better.
            let _ = self.file.set_len(self.end);
            return Err(loc_core::Error::io(&self.path)(error).into());
        }
        self.end += line.len() as u64;
        Ok(())
    }

    /// Flushes everything to the disk.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`].
    pub fn sync(&mut self) -> Result<()> {
        self.synced = Instant::now();
        Ok(self.file.sync_data().map_err(loc_core::Error::io(&self.path))?)
    }

    /// The path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Number of the grid's runs in it.
    pub fn kept(&self) -> usize {
        self.kept
    }

    /// Whether it holds a run of the grid, by its number.
    pub fn has(&self, index: usize) -> bool {
        self.places.get(index).is_some_and(Option::is_some)
    }

    /// Reads the available runs in the order of the grid.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`], [`Error::Recording`] for a line that has changed meanwhile, and
    /// what `each` reports.
    pub fn for_each(&self, mut each: impl FnMut(RunOutcome) -> Result<()>) -> Result<()> {
        let io = || loc_core::Error::io(self.path.clone());
        let mut reader = BufReader::new(File::open(&self.path).map_err(io())?);
        let mut at = 0_u64;
        let mut bytes = Vec::new();
        for place in self.places.iter().flatten().copied() {
            // Runs that follow each other in the grid mostly do so in the file.
            if place != at {
                reader.seek(SeekFrom::Start(place)).map_err(io())?;
            }
            bytes.clear();
            at = place + reader.read_until(b'\n', &mut bytes).map_err(io())? as u64;
            each(serde_json::from_slice(&bytes).map_err(|error| damaged(&self.path, 0, &error))?)?;
        }
        Ok(())
    }
}

/// Locks the file against other processes, as long as it is open.
///
/// A process that is being started holds a copy of every open file for a moment, with its lock;
/// hence the retries.
fn lock(file: &File) -> Result<(), TryLockError> {
    let mut left = PATIENCE;
    loop {
        match file.try_lock() {
            Err(TryLockError::WouldBlock) if left > 0 => left -= 1,
            Err(TryLockError::WouldBlock) => return Err(TryLockError::WouldBlock),
            // Some file systems have no locks; they are accepted.
            Ok(()) | Err(TryLockError::Error(_)) => return Ok(()),
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Records where a run's line begins, unless it is known already; returns the number of new runs.
fn keep(places: &mut [Option<u64>], grid: &Grid, outcome: &RunOutcome, place: u64) -> usize {
    let job: Job = outcome.job();
    match grid.index(job).and_then(|index| places.get_mut(index)) {
        Some(known @ None) => {
            *known = Some(place);
            1
        }
        // A run with a seed outside of the present range.
        _ => 0,
    }
}

fn line(value: &impl Serialize) -> Result<Vec<u8>> {
    let failed = |error: serde_json::Error| crate::config::error(FILE, &error.to_string());
    let mut line = serde_json::to_vec(value).map_err(failed)?;
    line.push(b'\n');
    Ok(line)
}

fn is_end(reader: &mut impl Read) -> bool {
    matches!(reader.read(&mut [0]), Ok(0))
}

/// Compares the first line with the study that continues.
fn check(path: &Path, line: &[u8], ours: &Fingerprint) -> Result<()> {
    let theirs: Fingerprint = serde_json::from_slice(line).map_err(|_| no_journal(path))?;
    match ours.difference(&theirs) {
        None => Ok(()),
        Some(difference) => Err(Error::OtherStudy { path: path.into(), difference }),
    }
}

fn no_journal(path: &Path) -> Error {
    let expected = "the journal of a study".into();
    Error::Recording { path: path.into(), expected, found: "a file of another kind".into() }
}

fn damaged(path: &Path, number: usize, error: &serde_json::Error) -> Error {
    let place = if number > 0 { format!(" in line {number}") } else { String::new() };
    Error::Recording {
        path: path.into(),
        expected: format!("a finished run{place}"),
        found: format!("a damaged line ({error}); delete that line, and the run is done again"),
    }
}

impl Fingerprint {
    /// The difference to another study, in words; `None` for the same study.
    fn difference(&self, kept: &Fingerprint) -> Option<String> {
        let lists = [
            ("the scenario", &self.scenario, &kept.scenario),
            ("--vary", &self.vary, &kept.vary),
            ("--method", &self.methods, &kept.methods),
        ];
        for (what, ours, theirs) in lists {
            if ours != theirs {
                let named = |from: &[String], without: &[String]| {
                    let differs = from.iter().find(|entry| !without.contains(entry));
                    match differs {
                        Some(entry) => entry.clone(),
                        None if from.is_empty() => "nothing".to_owned(),
                        None => from.join(", "),
                    }
                };
                let (theirs, ours) = (named(theirs, ours), named(ours, theirs));
                return Some(format!("{what} was `{theirs}` there and is `{ours}` now"));
            }
        }
        let texts = [
            ("--align", &self.align, &kept.align),
            ("the build of loc-sim", &self.program, &kept.program),
        ];
        let differs = texts.into_iter().find(|(_, ours, theirs)| ours != theirs);
        if let Some((what, ours, theirs)) = differs {
            return Some(format!("{what} was `{theirs}` there and is `{ours}` now"));
        }
        (self.journal != kept.journal).then(|| "the form of the file is another".to_owned())
    }
}
