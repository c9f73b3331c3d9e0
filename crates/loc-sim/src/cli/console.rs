//! The terminal: progress bar, Ctrl-C, and text in the width of the terminal.

use super::Global;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

const STEPS: u64 = 1000;

/// A progress bar on a terminal, shown after 1 s.
pub(super) struct Progress {
    bar: Option<ProgressBar>,
    started: Instant,
    position: u64,
    what: String,
    wanted: bool,
}

impl Progress {
    pub(super) fn new(what: &str, global: &Global) -> Self {
        let wanted = !global.quiet && std::io::stderr().is_terminal();
        Progress { bar: None, started: Instant::now(), position: 0, what: what.into(), wanted }
    }

    /// The share of the work that is done, in \[0, 1\].
    pub(super) fn update(&mut self, share: f64) {
        let position = (share * STEPS as f64) as u64;
        if !self.wanted || position == self.position {
            return;
        }
        self.position = position;
        let elapsed = self.started.elapsed();
        if elapsed < Duration::from_secs(1) {
            return;
        }
        let bar = self.bar.get_or_insert_with(|| {
            let style = ProgressStyle::with_template("{msg} {wide_bar} {percent:>3} % {prefix}");
            let bar = ProgressBar::new(STEPS).with_message(self.what.clone());
            bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        });
        let left = elapsed.as_secs_f64() * (1.0 - share) / share;
        bar.set_prefix(format!("{left:.0} s left"));
        bar.set_position(position);
    }

    pub(super) fn finish(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Incomplete files, which Ctrl-C removes.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Installs the handler of Ctrl-C: it waits for the writing of results ([`uninterrupted`]), removes
/// incomplete files and ends the program with the exit code of an interruption.
pub(super) fn handle_interrupts() -> anyhow::Result<()> {
    ctrlc::set_handler(|| {
        // The lock is held to the end of the process, so no writing begins any more.
        let files = unfinished();
        for file in files.iter() {
            let _ = std::fs::remove_file(file);
        }
        let _ = writeln!(std::io::stderr(), "\ninterrupted");
        std::process::exit(super::INTERRUPTED.into());
    })?;
    Ok(())
}

/// Runs short work, such as the writing of results, that Ctrl-C must not interrupt.
pub(super) fn uninterrupted<T>(work: impl FnOnce() -> T) -> T {
    let _files = unfinished();
    work()
}

/// Lets `fill` write a file, which Ctrl-C removes meanwhile.
pub(super) fn filling<T>(path: &Path, fill: impl FnOnce() -> T) -> T {
    // An existing path is a pipe or a device, which stays.
    let is_new = !path.exists();
    unfinished().extend(is_new.then(|| path.to_owned()));
    let filled = fill();
    unfinished().retain(|known| known != path);
    filled
}

/// A file that is removed by Ctrl-C, and on drop.
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
        // A completed file has been renamed, so that this finds none.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// The width of the terminal in columns; `None` where standard output is not a terminal.
pub(super) fn width() -> Option<usize> {
    let terminal = console::Term::stdout();
    let (_, columns) = terminal.is_term().then(|| terminal.size_checked()).flatten()?;
    (columns > 0).then_some(columns.into())
}

/// The text in lines of at most `width` columns: tables lose columns on the right, with a remark;
/// other lines are broken between words.
pub(super) fn narrow(text: &str, width: usize) -> String {
    let lines: Vec<&str> = text.lines().collect();
    if lines.iter().all(|line| columns(line) <= width) {
        return text.to_owned();
    }
    let mut narrowed = Vec::new();
    let mut at = 0;
    while at < lines.len() {
        let rows = lines[at..].iter().take_while(|line| is_row(line)).count();
        if rows > 1 {
            narrowed.extend(table(&lines[at..at + rows], width));
        } else {
            narrowed.extend(wrapped(lines[at], width));
        }
        at += rows.max(1);
    }
    narrowed.join("\n")
}

fn columns(line: &str) -> usize {
    line.chars().count()
}

/// Rows of tables have gaps of several spaces.
fn is_row(line: &str) -> bool {
    line.trim().contains("  ")
}

/// The rows up to the last gap between columns that fits.
fn table(rows: &[&str], width: usize) -> Vec<String> {
    let rows: Vec<Vec<char>> = rows.iter().map(|row| row.chars().collect()).collect();
    let longest = rows.iter().map(Vec::len).max().unwrap_or(0);
    if longest <= width {
        return rows.iter().map(|row| row.iter().collect()).collect();
    }
    let is_free = |column: usize| rows.iter().all(|row| row.get(column).is_none_or(|c| *c == ' '));
    let gap = (1..=width).rev().find(|&column| is_free(column) && !is_free(column - 1));
    let cut = |row: &[char], range: Range<usize>| -> String {
        row[range.start.min(row.len())..range.end.min(row.len())].iter().collect()
    };
    let end = gap.unwrap_or(width);
    let mut cut: Vec<String> =
        rows.iter().map(|row| cut(row, 0..end).trim_end().to_owned()).collect();
    cut.extend(wrapped("(more columns in a wider terminal, or with --json)", width));
    cut
}

/// A line broken between words; a word that is too long stays whole.
fn wrapped(line: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in line.split(' ') {
        match lines.last_mut() {
            Some(last) if columns(last) + 1 + columns(word) <= width => {
                last.push(' ');
                last.push_str(word);
            }
            Some(_) => lines.push(format!("  {word}")),
            None => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::narrow;

    const TABLE: &str = "a drive of one minute, seed 1\n\
                         method    ATE [m]   sensor\n\
                         ekf         0.152   camera\n\
                         mcl-all    10.024   laser\n\
                         written to out";

    #[test]
    fn what_fits_stays_as_it_is() {
        assert_eq!(narrow(TABLE, 29), TABLE);
    }

    #[test]
    fn tables_lose_whole_columns_and_lines_are_broken() {
        let narrow = narrow(TABLE, 22);
        let lines: Vec<&str> = narrow.lines().collect();
        assert!(lines.iter().all(|line| line.len() <= 22), "{narrow}");
        assert_eq!(lines[..3], ["a drive of one minute,", "  seed 1", "method    ATE [m]"]);
        assert_eq!(lines[4], "mcl-all    10.024");
        assert_eq!(lines[5], "(more columns in a");
        assert_eq!(lines.last(), Some(&"written to out"));
    }

    #[test]
    fn a_word_that_is_too_long_stays_whole() {
        assert_eq!(narrow("written to /a/long/path", 12), "written to\n  /a/long/path");
    }
}
