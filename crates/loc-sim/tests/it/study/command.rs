//! The command `loc-sim study` as its users run it.

use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

fn study(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_loc-sim"));
    command.current_dir(folder).arg("study").args(arguments).output().unwrap()
}

fn stdout(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn failure(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(1));
    assert!(output.stdout.is_empty());
    String::from_utf8(output.stderr.clone()).unwrap()
}

#[test]
fn a_study_prints_tables_and_writes_files() {
    let folder = TempDir::new().unwrap();
    let arguments = [
        "landmark-drive",
        "--runs",
        "6",
        "--method",
        "ekf",
        "--vary",
        "camera.range_sigma=0.05:0.2:3",
    ];
    let text = stdout(&study(folder.path(), &arguments));
    assert!(text.contains("landmark-drive: 18 runs, seeds 1 to 6"), "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    assert!(text.contains("\nrange_sigma  method ") && text.contains("\n0.125 "), "{text}");
    assert!(text.contains("NEES/dof") && text.contains("white"), "{text}");
    let out = folder.path().join("out/study-landmark-drive");
    let mut names: Vec<String> = fs::read_dir(&out)
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    let expected = [
        "accuracy-by-camera-range-sigma.svg",
        "consistency-by-camera-range-sigma.svg",
        "journal.jsonl",
        "report.html",
        "runs.csv",
        "runs.parquet",
        "study.json",
        "times.csv",
    ];
    assert_eq!(names, expected);
    let report = fs::read_to_string(out.join("report.html")).unwrap();
    assert_eq!(report.matches("<svg").count(), 2);
    assert!(report.contains("loc-sim study landmark-drive --runs 6"));
    for figure in &expected[..2] {
        let svg = fs::read_to_string(out.join(figure)).unwrap();
        roxmltree::Document::parse(&svg).unwrap();
    }
    // The same command again has nothing left to do, and says the same.
    let csv = fs::read(out.join("runs.csv")).unwrap();
    let journal = fs::read(out.join("journal.jsonl")).unwrap();
    assert_eq!(stdout(&study(folder.path(), &arguments)), text);
    assert_eq!(fs::read(out.join("runs.csv")).unwrap(), csv);
    assert_eq!(fs::read(out.join("journal.jsonl")).unwrap(), journal);
}

#[test]
fn json_is_for_programs_and_quiet_is_quiet() {
    let folder = TempDir::new().unwrap();
    let drive = [
        "landmark-drive",
        "--runs",
        "5",
        "--seed",
        "3",
        "--method",
        "ekf",
        "--method",
        "dead-reckoning",
        "--out",
        "o",
    ];
    let mut arguments = drive.to_vec();
    arguments.push("--json");
    let json: Value = serde_json::from_str(&stdout(&study(folder.path(), &arguments))).unwrap();
    assert_eq!(
        (&json["runs"], &json["first_seed"], json["groups"].as_array().unwrap().len()),
        (&5.into(), &3.into(), 2)
    );
    let ekf = &json["groups"][0];
    assert_eq!((&ekf["method"], &ekf["success_rate"]), (&"ekf".into(), &1.0.into()));
    assert!(ekf["consistency"]["nees_interval"][0].is_f64() && ekf["settings"].is_object());
    assert!(json["groups"][1]["consistency"]["nis_mean"].is_null());
    let written = fs::read_to_string(folder.path().join("o/study.json")).unwrap();
    assert_eq!(serde_json::from_str::<Value>(&written).unwrap(), json);
    for figure in ["distribution.svg", "nees.svg", "whiteness.svg"] {
        assert!(folder.path().join("o").join(figure).is_file());
    }
    let mut arguments = drive.to_vec();
    arguments.push("--quiet");
    let output = study(folder.path(), &arguments);
    assert!(stdout(&output).is_empty() && output.stderr.is_empty());
}

#[test]
fn bad_input_is_one_line_that_names_it() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    for (arguments, message) in [
        (["landmark-drive", "--runs", "0"], "error: --runs: expected at least 1, got `0`\n"),
        (
            ["landmark-drive", "--runs", "1000001"],
            "error: --runs, --vary: expected at most 1000000 runs, got `1 settings x 1000001 runs = 1000001`\n",
        ),
        (
            ["landmark-drive", "--vary", "filter.partikel=1"],
            "error: --vary filter.partikel=1: unknown field `partikel`, expected one of `robot`, `line_matching`",
        ),
        (["lanmark-drive", "--runs", "1"], "error: scenario: expected one of overview,"),
        (["missing.toml", "--runs", "1"], "error: missing.toml: No such file or directory"),
        (["landmark-drive", "--out", "file"], "error: file: File exists"),
        (["landmark-drive", "--out", "/proc/o"], "error: /proc/o: No such file or directory"),
        (
            ["diversity", "--method", "mcl"],
            "error: study: expected a scenario with a robot that moves, got `diversity`\n",
        ),
    ] {
        let error = failure(&study(folder.path(), &arguments));
        assert!(error.starts_with(message) && error.lines().count() == 1, "{error}");
    }
    assert_eq!(study(folder.path(), &["landmark-drive", "--success", "x"]).status.code(), Some(2));
    assert_eq!(study(folder.path(), &["landmark-drive", "--runs", "-1"]).status.code(), Some(2));
    assert_eq!(study(folder.path(), &[]).status.code(), Some(2));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is written");
}
