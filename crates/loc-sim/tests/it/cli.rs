//! The command as its users run it.

use loc_sim::scenario::builtin;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

fn loc_sim(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_loc-sim"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

fn stdout(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// Exit code and the one line that a failure leaves.
fn failure(folder: &Path, arguments: &[&str]) -> (i32, String) {
    let output = loc_sim(folder, arguments);
    assert!(output.stdout.is_empty());
    (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
}

fn entries(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

#[test]
fn without_arguments_it_runs_the_overview() {
    let folder = TempDir::new().unwrap();
    let table = stdout(&loc_sim(folder.path(), &[]));
    assert!(table.lines().all(|line| line.len() <= 80), "{table}");
    assert!(table.contains("\ndead-reckoning ") && table.contains("\nekf "), "{table}");
    let out = folder.path().join("out/overview");
    let summary: Value =
        serde_json::from_str(&fs::read_to_string(out.join("summary.json")).unwrap()).unwrap();
    let methods = summary["methods"].as_object().unwrap();
    let figures = [
        "biases.svg",
        "clouds.svg",
        "consistency.svg",
        "errors.svg",
        "fusion.svg",
        "histogram.svg",
        "lines.svg",
        "map.svg",
        "report.html",
    ];
    let mut expected: Vec<String> = figures.map(str::to_owned).to_vec();
    expected.extend(["summary.json", "truth.tum"].map(str::to_owned));
    for method in methods.keys() {
        expected.push(format!("covariance_{method}.csv"));
        expected.push(format!("estimate_{method}.tum"));
    }
    expected.sort();
    assert_eq!(entries(&out), expected);
    for method in methods.keys() {
        let row = table.lines().find(|line| line.split(' ').next() == Some(method)).unwrap();
        assert!(row.contains(if method.ends_with("-global") { " unknown " } else { " known " }));
    }
    let found = &methods["mcl-global"];
    assert!(found["converged_at_s"].as_f64().unwrap() < 1.0, "{found}");
    assert!(found["ate_since_converged_m"].as_f64().unwrap() < 0.04, "{found}");
    let ekf = &summary["methods"]["ekf"];
    assert!(ekf["ate_rmse_m"].as_f64().unwrap() < 0.3);
    assert!(methods["mcl"]["ate_rmse_m"].as_f64().unwrap() < 0.04);
    assert!(ekf["nees_mean"].is_f64() && ekf["converged_at_s"].is_null());
    assert!(summary["methods"]["dead-reckoning"]["nis_mean"].is_null());
    let report = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(!report.contains("src=") && !report.contains("href=\"http"), "needs no network");
    assert!(report.matches("<svg").count() >= 3);
    // Twelve methods in one figure: means that are distinct, one entry for all ellipses.
    let errors = fs::read_to_string(out.join("errors.svg")).unwrap();
    assert!(errors.contains("means over windows of 0.9 s") && errors.len() < 200_000);
    let map = fs::read_to_string(out.join("map.svg")).unwrap();
    assert_eq!(map.matches("2 sigma, each in its colour").count(), 1);
}

/// Every estimate has exactly the stamps of the truth, at most 10 a second, and `eval` over the
/// files gives the figures of the summary.
#[test]
fn files_and_summary_agree() {
    let folder = TempDir::new().unwrap();
    let json = stdout(&loc_sim(
        folder.path(),
        &[
            "run",
            "overview",
            "--json",
            "--out",
            "o",
            "--method",
            "ekf",
            "--method",
            "dead-reckoning",
        ],
    ));
    let summary: Value = serde_json::from_str(&json).unwrap();
    let read = |name: &str| fs::read_to_string(folder.path().join("o").join(name)).unwrap();
    let stamps = |name: &str| -> Vec<f64> {
        let text = read(name);
        let lines = text.lines().filter(|line| !line.starts_with(['#', 't']));
        lines.map(|line| line.split([' ', ',']).next().unwrap().parse().unwrap()).collect()
    };
    let truth = stamps("truth.tum");
    assert!(truth.windows(2).all(|pair| pair[1] - pair[0] > 0.0999));
    for method in ["ekf", "dead-reckoning"] {
        assert_eq!(stamps(&format!("estimate_{method}.tum")), truth);
        assert_eq!(stamps(&format!("covariance_{method}.csv")), truth);
        let estimate = format!("o/estimate_{method}.tum");
        let eval = stdout(&loc_sim(folder.path(), &["eval", &estimate, "o/truth.tum", "--json"]));
        let eval: Value = serde_json::from_str(&eval).unwrap();
        let figures = &summary["methods"][method];
        for (ours, theirs) in [
            (&figures["ate_rmse_m"], &eval["ape"]["rmse_m"]),
            (&figures["rpe_trans_rmse_m"], &eval["rpe_trans"]["rmse_m"]),
            (&figures["rpe_rot_rmse_deg"], &eval["rpe_rot"]["rmse_deg"]),
        ] {
            assert!((ours.as_f64().unwrap() - theirs.as_f64().unwrap()).abs() < 1e-9);
        }
    }
}

#[test]
fn a_printed_scenario_can_be_changed_and_run() {
    let folder = TempDir::new().unwrap();
    for name in ["landmark-drive", "accelerated-vehicle"] {
        let config = stdout(&loc_sim(folder.path(), &["run", "--print-config", name]));
        fs::write(folder.path().join("mine.toml"), config).unwrap();
        let ours = stdout(&loc_sim(folder.path(), &["run", "mine.toml", "--out", "a"]));
        let theirs = stdout(&loc_sim(folder.path(), &["run", name, "--out", "a"]));
        assert_eq!(ours, theirs);
    }
    let other =
        stdout(&loc_sim(folder.path(), &["run", "landmark-drive", "--seed", "9", "--out", "a"]));
    assert!(other.contains("seed 9"));
    let settings = stdout(&loc_sim(folder.path(), &["replay", "--print-config"]));
    assert!(settings.contains("range_is_depth = true"));
}

#[test]
fn a_second_run_leaves_nothing_of_the_first_but_what_is_not_its_own() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("o");
    stdout(&loc_sim(folder.path(), &["run", "landmark-drive", "--out", "o"]));
    fs::write(out.join("notes.txt"), "mine").unwrap();
    stdout(&loc_sim(folder.path(), &["run", "two-sensors", "--method", "kf", "--out", "o"]));
    let expected = [
        "accuracy.svg",
        "covariance_kf.csv",
        "density.svg",
        "estimate_kf.tum",
        "notes.txt",
        "rail.svg",
        "report.html",
        "summary.json",
        "truth.tum",
    ];
    assert_eq!(entries(&out), expected);
}

#[test]
fn mistakes_are_reported_in_one_line_and_leave_no_files() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    fs::write(folder.path().join("bad.toml"), "name = \"bad\"\nseed = -1\n").unwrap();
    let scenarios = builtin::ALL.map(|(name, _)| name).join(", ");
    let unknown = format!("error: scenario: expected one of {scenarios}, got `landmark-dive`\n");
    for (arguments, message) in [
        (&["run", "landmark-dive"][..], unknown.as_str()),
        (&["run", "missing.toml"], "error: missing.toml: No such file or directory (os error 2)\n"),
        (
            &["run", "bad.toml"],
            "error: bad.toml: line 2: `seed = -1`: invalid value: integer `-1`, expected u64\n",
        ),
        (
            &["run", "circle-drive", "--method", "ekf"],
            "error: method ekf: expected landmarks, which circle-drive has not\n",
        ),
        (
            &["run", "circle-drive", "--method", "kf"],
            "error: method kf: expected a vehicle on a rail, which circle-drive has not\n",
        ),
        (
            &["run", "two-sensors", "--method", "ekf"],
            "error: method ekf: expected landmarks, which two-sensors has not\n",
        ),
        (&["replay", "nowhere"], "error: nowhere: No such file or directory (os error 2)\n"),
        (
            &["replay", "."],
            "error: .: expected a recording: a bag of ROS, an MCAP file, a folder with Barcodes.dat (mrclam), a file *_Input.txt (uwb-labyrinth), plaza1_ranges.csv (plaza), sensor_data.dat (landmark-course), *_bearing_range.csv (kf-slam-demo) or gtsam_landmark_obs.csv (victoria-park), a log of ODOM and FLASER lines (carmen), or of O and L lines (wean), got a folder without any of these\n",
        ),
        (
            &["run", "circle-drive", "--out", "file"],
            "error: cannot write the run: file: File exists (os error 17)\n",
        ),
        (
            &["run", "circle-drive", "--out", "/proc/out"],
            "error: cannot write the run: /proc/out: No such file or directory (os error 2)\n",
        ),
    ] {
        assert_eq!(failure(folder.path(), arguments), (1, message.to_owned()), "{arguments:?}");
    }
    assert_eq!(entries(folder.path()), ["bad.toml", "file"]);
    assert_eq!(failure(folder.path(), &["run", "--seed", "x"]).0, 2);
    assert_eq!(failure(folder.path(), &["run", "circle-drive", "--method", "gps"]).0, 2);
    assert_eq!(failure(folder.path(), &["fly"]).0, 2);
}

#[test]
fn quiet_is_quiet_and_list_lists() {
    let folder = TempDir::new().unwrap();
    assert_eq!(stdout(&loc_sim(folder.path(), &["run", "two-sensors", "--quiet"])), "");
    assert!(folder.path().join("out/two-sensors/summary.json").is_file());
    let list = stdout(&loc_sim(folder.path(), &["list"]));
    assert_eq!(list.lines().count(), builtin::ALL.len());
    assert!(list.contains("circle-drive "));
}

/// A scenario that runs no method writes its figure and its numbers the same way.
#[test]
fn an_illustration_is_written_like_a_run() {
    let folder = TempDir::new().unwrap();
    let arguments =
        ["run", "probability-map", "--json", "--set", "probability_map.step=0.5", "--out", "o"];
    let json = stdout(&loc_sim(folder.path(), &arguments));
    let summary: Value = serde_json::from_str(&json).unwrap();
    assert!(summary["error_m"].is_f64() && summary["beams"] == 60);
    let expected = ["probability.svg", "report.html", "summary.json"];
    assert_eq!(entries(&folder.path().join("o")), expected);
}

/// A conversion that fails leaves what stood there, and nothing beside it.
#[test]
fn conversions_are_whole_or_not_at_all() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    fs::write(path.join("a.log"), "FLASER 2 1 2 0 0 0 0 0 0 10 host 10\n").unwrap();
    fs::write(path.join("a.tum"), "kept").unwrap();
    let (code, error) =
        failure(path, &["convert", "a.log", "a.tum", "--to", "tum", "--track", "reference"]);
    assert_eq!((code, error.as_str()), (1, "error: a: expected true poses, got none\n"));
    assert_eq!(fs::read_to_string(path.join("a.tum")).unwrap(), "kept");
    let (_, error) = failure(path, &["convert", "a.log", "a.log", "--to", "carmen"]);
    assert!(error.contains("expected another file to write to than the recording"), "{error}");
    let (_, error) = failure(path, &["convert", "a.log", "no/a.tum", "--to", "tum"]);
    assert!(error.starts_with("error: no/a.tum"), "{error}");
    assert_eq!(entries(path), ["a.log", "a.tum"]);
    let text = stdout(&loc_sim(path, &["convert", "a.log", "a.tum", "--to", "tum"]));
    assert!(text.starts_with("1 poses written to a.tum\n"), "{text}");
    let text = fs::read_to_string(path.join("a.tum")).unwrap();
    assert!(text.lines().any(|line| line.starts_with("10")), "{text}");
}

#[test]
fn completions_and_the_manual_name_every_subcommand() {
    let folder = TempDir::new().unwrap();
    for arguments in [["completions", "bash"].as_slice(), &["completions", "fish"], &["man"]] {
        let text = stdout(&loc_sim(folder.path(), arguments));
        for name in ["run", "replay", "study", "eval"] {
            assert!(text.contains(name), "{arguments:?}: {name}");
        }
    }
    let (code, error) = failure(folder.path(), &["completions", "csh"]);
    assert!(code == 2 && error.contains("bash"), "{error}");
}
