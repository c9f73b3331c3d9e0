//! A study that is killed, interrupted or runs out of disk loses nothing and does nothing twice.
#![cfg(unix)]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

const RUNS: usize = 80;

/// 80 runs of about ten milliseconds each.
fn command(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_loc-sim"));
    command.current_dir(folder).args(arguments()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn arguments() -> Vec<&'static str> {
    let text = "study landmark-drive --runs 40 --vary filter.particles=300,400 --method mcl --out o --threads 2";
    text.split(' ').collect()
}

fn finish(folder: &Path) -> Vec<u8> {
    let output = command(folder).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    fs::read(folder.join("o/runs.csv")).unwrap()
}

/// The finished runs that the journal holds, each as (setting, seed).
fn runs(folder: &Path) -> Vec<(u64, u64)> {
    let text = fs::read_to_string(folder.join("o/journal.jsonl")).unwrap_or_default();
    let whole = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
    let run = |line: &str| {
        let value: serde_json::Value = serde_json::from_str(line).unwrap();
        (value["cell"].as_u64().unwrap(), value["seed"].as_u64().unwrap())
    };
    whole.lines().skip(1).map(run).collect()
}

/// Waits until the journal holds so many runs.
fn wait_for(folder: &Path, child: &mut Child, count: usize) {
    let path = folder.join("o/journal.jsonl");
    let started = Instant::now();
    while child.try_wait().unwrap().is_none() {
        let lines = fs::read(&path).map_or(0, |text| text.iter().filter(|&&b| b == b'\n').count());
        if lines > count {
            return;
        }
        assert!(started.elapsed() < Duration::from_secs(60), "the study does not get on");
        std::thread::sleep(Duration::from_millis(1));
    }
    panic!("the study was done before it could be interrupted");
}

fn signal(child: &Child, name: &str) {
    let id = child.id().to_string();
    assert!(Command::new("kill").args([name, &id]).status().unwrap().success());
}

#[test]
fn killed_three_times_it_gives_the_same_table() {
    let undisturbed = TempDir::new().unwrap();
    let expected = finish(undisturbed.path());
    let folder = TempDir::new().unwrap();
    let mut kept = Vec::new();
    for round in 1..=3_usize {
        let mut child = command(folder.path()).spawn().unwrap();
        wait_for(folder.path(), &mut child, kept.len() + 7 * round);
        // Some moment within the runs that come next, another one each time.
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap();
        let delay = Duration::from_micros(u64::from(now.subsec_nanos()) % 8_000);
        println!("killed {delay:?} after a run");
        std::thread::sleep(delay);
        child.kill().unwrap();
        child.wait().unwrap();
        let now = runs(folder.path());
        assert!(now.len() > kept.len() && now.starts_with(&kept), "finished runs are kept");
        kept = now;
    }
    assert!(kept.len() < RUNS);
    assert!(finish(folder.path()) == expected, "the tables differ");
    let all = runs(folder.path());
    assert!(all.starts_with(&kept));
    assert_eq!((all.len(), all.iter().collect::<BTreeSet<_>>().len()), (RUNS, RUNS), "none twice");
}

fn end(child: Child) -> (Output, String) {
    let output = child.wait_with_output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    (output, text)
}

#[test]
fn ctrl_c_finishes_begun_runs_and_reports_how_to_continue() {
    let folder = TempDir::new().unwrap();
    let mut child = command(folder.path()).spawn().unwrap();
    wait_for(folder.path(), &mut child, 5);
    signal(&child, "-INT");
    let (output, text) = end(child);
    assert_eq!(output.status.code(), Some(130), "{text}");
    let count = runs(folder.path()).len();
    let message =
        format!("interrupted: {count} of 80 runs are done and kept in o; the same command goes on");
    assert!(text.contains(&message) && output.stdout.is_empty(), "{text}");
    let journal = fs::read(folder.path().join("o/journal.jsonl")).unwrap();
    assert!(journal.ends_with(b"}\n"), "nothing half");
    assert!(!folder.path().join("o/runs.csv").exists());
    finish(folder.path());
    assert_eq!(runs(folder.path()).len(), RUNS);
}

/// A limit on the size of files stands for a disk that is full.
#[test]
fn a_full_disk_keeps_what_is_done() {
    let folder = TempDir::new().unwrap();
    let line = format!(
        "trap '' XFSZ; ulimit -f 64; exec {} {}",
        env!("CARGO_BIN_EXE_loc-sim"),
        arguments().join(" ")
    );
    let output =
        Command::new("bash").current_dir(folder.path()).args(["-c", &line]).output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{text}");
    let count = runs(folder.path()).len();
    assert!((1..RUNS).contains(&count), "{text}");
    assert!(
        text.contains(&format!(
            "stopped, {count} of 80 runs are kept in o: o/journal.jsonl: File too large"
        )),
        "{text}"
    );
    let journal = fs::read(folder.path().join("o/journal.jsonl")).unwrap();
    assert!(journal.ends_with(b"}\n"), "half a line is taken off");
    finish(folder.path());
    assert_eq!(runs(folder.path()).len(), RUNS);
}
