//! The command as a good program of the command line: what it says where, and what it leaves behind
//! when something stops it.
#![cfg(unix)]

use serde_json::Value;
use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

const PROGRAM: &str = env!("CARGO_BIN_EXE_loc-sim");

fn loc_sim(folder: &Path, line: &str) -> Output {
    let mut command = Command::new(PROGRAM);
    command.current_dir(folder).args(line.split(' ')).output().unwrap()
}

/// A line of the shell, with the program as `$0`.
fn shell(folder: &Path, line: &str) -> Output {
    Command::new("bash").current_dir(folder).args(["-c", line, PROGRAM]).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Everything in a folder, deep.
fn all_entries(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.path().is_dir() {
            let deeper = all_entries(&entry.path());
            names.extend(deeper.iter().map(|inner| format!("{name}/{inner}")));
        }
        names.push(name);
    }
    names.sort();
    names
}

/// The same line under `--quiet` and `--json`: the one says nothing, the other one JSON value; both
/// leave standard error alone.
#[test]
fn quiet_and_json_are_what_they_say() {
    for line in [
        "run two-sensors --out o",
        "run mailbox --out o",
        "sense laser --out o",
        "study two-sensors --runs 2 --out s",
    ] {
        let folder = TempDir::new().unwrap();
        let quiet = loc_sim(folder.path(), &format!("{line} --quiet"));
        assert!(quiet.status.success() && quiet.stdout.is_empty(), "{line}");
        assert_eq!(text(&quiet.stderr), "", "{line}");
        let json = loc_sim(folder.path(), &format!("{line} --json"));
        let value: Value = serde_json::from_slice(&json.stdout).unwrap();
        assert!(value.is_object(), "{line}");
        assert!(text(&json.stderr).lines().count() <= 1, "{line}: {}", text(&json.stderr));
    }
    let folder = TempDir::new().unwrap();
    for line in ["list --json", "list --ids --json", "sense --list --json"] {
        let output = loc_sim(folder.path(), line);
        assert!(serde_json::from_slice::<Value>(&output.stdout).unwrap().is_array(), "{line}");
    }
}

/// A closed pipe is no failure, and the run is written all the same.
#[test]
fn piped_into_head_it_ends_well() {
    let folder = TempDir::new().unwrap();
    let line =
        "set -o pipefail; \"$0\" list --ids | head -1; \"$0\" run two-sensors --out o | head -1";
    let output = shell(folder.path(), line);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!((text(&output.stdout).lines().count(), text(&output.stderr).as_str()), (2, ""));
    assert!(folder.path().join("o/summary.json").is_file());
    let closed = shell(folder.path(), "\"$0\" run two-sensors --out p >&-");
    assert!(text(&closed.stderr).lines().count() <= 1, "{}", text(&closed.stderr));
    assert!(folder.path().join("p/summary.json").is_file());
}

/// Where standard output is a full disk, that is an error in one line.
#[test]
fn output_onto_a_full_disk_is_an_error() {
    if !Path::new("/dev/full").exists() {
        println!("skipped: there is no /dev/full");
        return;
    }
    let folder = TempDir::new().unwrap();
    for line in ["list", "run two-sensors --out o", "run two-sensors --out o --mcap /dev/full"] {
        let target = if line.contains("/dev/full") { "/dev/null" } else { "/dev/full" };
        let output = shell(folder.path(), &format!("\"$0\" {line} > {target}"));
        let reported = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{line}: {reported}");
        assert!(
            reported.contains("No space left on device") && reported.lines().count() == 1,
            "{reported}"
        );
    }
}

/// A limit on the size of files stands for a disk that is full while the run is written.
#[test]
fn a_run_that_does_not_fit_leaves_nothing() {
    let folder = TempDir::new().unwrap();
    for line in
        ["run landmark-drive --out a/b/c", "sense laser --out a/s", "map make office --out a/m"]
    {
        let limited = format!("trap '' XFSZ; ulimit -f 8; \"$0\" {line}");
        let output = shell(folder.path(), &limited);
        let reported = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{reported}");
        assert!(reported.contains("File too large") && reported.lines().count() == 1, "{reported}");
        assert_eq!(all_entries(folder.path()), Vec::<String>::new(), "{line}");
    }
    // What was there before is left as it was.
    assert!(loc_sim(folder.path(), "run two-sensors --out o").status.success());
    let before = all_entries(folder.path());
    let summary = fs::read(folder.path().join("o/summary.json")).unwrap();
    let line = "trap '' XFSZ; ulimit -f 8; \"$0\" run landmark-drive --out o";
    assert_eq!(shell(folder.path(), line).status.code(), Some(1));
    assert_eq!(all_entries(folder.path()), before);
    assert_eq!(fs::read(folder.path().join("o/summary.json")).unwrap(), summary);
}

/// A study whose journal cannot be begun leaves nothing either.
#[test]
fn a_study_that_cannot_begin_leaves_nothing() {
    let folder = TempDir::new().unwrap();
    let line = "trap '' XFSZ; ulimit -f 0; \"$0\" study landmark-drive --runs 2 --out a/b";
    let output = shell(folder.path(), line);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    assert_eq!(all_entries(folder.path()), Vec::<String>::new());
}

/// A file where a folder should be: for root as for anybody else.
#[test]
fn a_place_that_cannot_be_written_is_named() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("file"), "mine").unwrap();
    for line in [
        "run two-sensors --out file/o",
        "run mailbox --out file/o",
        "sense laser --out file",
        "study landmark-drive --runs 1 --out file/o",
        "map make office --out file/o",
        "run two-sensors --out o --mcap file/o.mcap",
    ] {
        let output = loc_sim(folder.path(), line);
        let reported = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{line}: {reported}");
        assert!(reported.contains("file") && reported.lines().count() == 1, "{line}: {reported}");
        assert_eq!(all_entries(folder.path()), ["file"], "{line}");
    }
    assert_eq!(fs::read(folder.path().join("file")).unwrap(), b"mine");
}

/// Long enough that it can be stopped.
fn long_run(folder: &Path, arguments: &str) -> Child {
    let line = format!("run position-tracking --set tour.duration=3000 --out a/o {arguments}");
    let mut command = Command::new(PROGRAM);
    command.current_dir(folder).args(line.trim().split(' '));
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn ended(child: &mut Child) -> (Option<i32>, String) {
    let started = Instant::now();
    while child.try_wait().unwrap().is_none() {
        assert!(started.elapsed() < Duration::from_secs(20), "it does not end");
        std::thread::sleep(Duration::from_millis(5));
    }
    let mut reported = String::new();
    child.stderr.take().unwrap().read_to_string(&mut reported).unwrap();
    (child.wait().unwrap().code(), reported)
}

#[test]
fn ctrl_c_in_a_run_leaves_nothing() {
    for arguments in ["", "--mcap m.mcap"] {
        let folder = TempDir::new().unwrap();
        let mut child = long_run(folder.path(), arguments);
        // With an MCAP file one sees that it is under way.
        let started = Instant::now();
        while started.elapsed() < Duration::from_millis(400)
            || (!arguments.is_empty() && all_entries(folder.path()).is_empty())
        {
            assert!(started.elapsed() < Duration::from_secs(20), "it does not begin");
            std::thread::sleep(Duration::from_millis(5));
        }
        let id = child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
        assert_eq!(ended(&mut child), (Some(130), "\ninterrupted\n".to_owned()));
        assert_eq!(all_entries(folder.path()), Vec::<String>::new());
    }
}

/// A kill leaves no file that looks complete.
#[test]
fn a_killed_run_leaves_nothing_that_looks_whole() {
    let folder = TempDir::new().unwrap();
    let mut child = long_run(folder.path(), "--mcap m.mcap");
    std::thread::sleep(Duration::from_millis(500));
    child.kill().unwrap();
    child.wait().unwrap();
    let left = all_entries(folder.path());
    assert!(left.iter().all(|name| name.ends_with(".part")), "{left:?}");
}

/// What a terminal of a width shows; `None` where there is no `script` to make one.
fn on_a_terminal(folder: &Path, width: u32, line: &str) -> Option<String> {
    // The progress bar of a busy machine is not what is looked at.
    let inner = format!("stty rows 24 cols {width}; {PROGRAM} {line} 2>/dev/null");
    let mut command = Command::new("script");
    command.current_dir(folder).args(["-qec", &inner, "/dev/null"]).stdin(Stdio::null());
    let Ok(output) = command.env("NO_COLOR", "1").env("TERM", "xterm-256color").output() else {
        println!("skipped: there is no `script` to make a terminal");
        return None;
    };
    let shown = text(&output.stdout).replace('\r', "");
    assert!(output.status.success(), "{line}: {shown}");
    // A slow machine shows a progress bar, which is wiped out before what comes next.
    let last = |line: &str| line.rsplit("\u{1b}[2K").next().unwrap_or_default().to_owned() + "\n";
    Some(shown.lines().map(last).collect())
}

#[test]
fn a_terminal_of_60_columns_is_enough() {
    let folder = TempDir::new().unwrap();
    for line in [
        "run landmark-drive --out o",
        "run overview --set tour.duration=2 --out o",
        "study landmark-drive --runs 3 --method ekf --out s",
        "list",
        "list --ids",
        "sense --list",
    ] {
        let Some(shown) = on_a_terminal(folder.path(), 60, line) else { return };
        let widest = shown.lines().map(|line| line.chars().count()).max().unwrap();
        assert!((20..=60).contains(&widest), "{line}: {widest} columns\n{shown}");
        assert!(!shown.contains('\u{1b}'), "{line}: no colours under NO_COLOR\n{shown}");
    }
    let wide = on_a_terminal(folder.path(), 100, "run landmark-drive --out o").unwrap();
    assert!(wide.contains(" rejected\n") && !wide.contains("more columns"), "{wide}");
}

/// Usage and errors are without colours without a terminal, or if they are switched off.
#[test]
fn there_are_no_colours_in_a_file() {
    let folder = TempDir::new().unwrap();
    for line in ["--help", "run --help", "fly", "run two-sensors --method x"] {
        let output = loc_sim(folder.path(), line);
        let reported = text(&output.stdout) + &text(&output.stderr);
        assert!(!reported.contains('\u{1b}') && reported.len() > 20, "{line}: {reported}");
    }
}
