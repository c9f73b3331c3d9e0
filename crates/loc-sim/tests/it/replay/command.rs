//! The command `loc-sim replay` over recordings with a laser.

use super::*;
use loc_maps::grid::io::{self, ImageFormat, Mode};
use serde_json::Value;
use std::fs;
use std::process::{Command, Output};
use tempfile::TempDir;

/// A folder with the hall, its log, and the log without a reference.
fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::write(path("hall.log"), corrected()).unwrap();
    fs::write(path("raw.log"), uncorrected()).unwrap();
    io::save(&hall(), path("hall.yaml"), ImageFormat::Pgm, Mode::Trinary).unwrap();
    folder
}

fn replay(folder: &TempDir, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_loc-sim"));
    command.current_dir(folder.path()).arg("replay").args(arguments).output().unwrap()
}

fn summary(folder: &TempDir, arguments: &[&str]) -> Value {
    let output = replay(folder, &[arguments, &["--json"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn failure(folder: &TempDir, arguments: &[&str]) -> String {
    let output = replay(folder, arguments);
    assert_eq!((output.status.success(), output.stdout.len()), (false, 0), "{arguments:?}");
    String::from_utf8(output.stderr).unwrap()
}

const TRACK: [&str; 3] = ["hall.log", "--map", "hall.yaml"];

#[test]
fn dead_reckoning_and_mcl_run_where_none_is_named() {
    let folder = folder();
    let summary = summary(&folder, &TRACK);
    let methods = summary["methods"].as_object().unwrap();
    assert_eq!(methods.keys().collect::<Vec<_>>(), ["dead-reckoning", "mcl"]);
    assert!(methods["mcl"]["ate_rmse_m"].as_f64().unwrap() < 0.1);
    assert_eq!(summary["seed"], 1);
    let svg = fs::read_to_string(folder.path().join("out/hall/map.svg")).unwrap();
    assert!(svg.contains("data:image/png;base64"));
    // Nobody knows where odometry starts in the raw log.
    let raw = super::command::summary(&folder, &["raw.log", "--map", "hall.yaml", "--global"]);
    assert_eq!(raw["methods"].as_object().unwrap().len(), 1);
    let truth = folder.path().join("out/raw/truth.tum");
    assert!(!truth.exists() && folder.path().join("out/raw/estimate_mcl.tum").exists());
}

#[test]
fn seeds_and_threads() {
    let folder = folder();
    let estimate = |more: &[&str]| {
        summary(&folder, &[&TRACK[..], &["--method", "mcl"], more].concat());
        fs::read_to_string(folder.path().join("out/hall/estimate_mcl.tum")).unwrap()
    };
    let first = estimate(&[]);
    assert_eq!(first, estimate(&["--seed", "1", "--threads", "2"]));
    assert_ne!(first, estimate(&["--seed", "2"]));
    let fewer = estimate(&[
        "--set",
        "filter.mcl.particles.max_particles=600",
        "--set",
        "start.heading_sigma_deg=1",
    ]);
    assert_ne!(first, fewer);
}

#[test]
fn a_kidnapping_shows_in_the_summary() {
    let folder = folder();
    let odometry = [&TRACK[..], &["--method", "dead-reckoning"]].concat();
    let kidnapped = summary(&folder, &[&odometry[..], &["--kidnap", "5"]].concat());
    let figures = &kidnapped["methods"]["dead-reckoning"];
    assert!(figures["recovered_after_s"].is_null() && figures["converged_at_s"].is_null());
    assert!(figures["final_error_m"].as_f64().unwrap() > 4.0, "{figures}");
    // The way on which it was carried does not count.
    let distance = |summary: &Value| summary["distance_m"].as_f64().unwrap();
    let shorter = distance(&summary(&folder, &odometry)) - distance(&kidnapped);
    assert!((4.9..5.6).contains(&shorter), "{shorter}");
}

#[test]
fn parameters_of_nav2_are_taken() {
    let folder = folder();
    let text = "amcl:\n  ros__parameters:\n    max_particles: 1000\n    update_min_d: 0.6\n    \
                scan_topic: scan\n    update_min_a: 1.0\n    random_seed: 9\n";
    fs::write(folder.path().join("amcl.yaml"), text).unwrap();
    let arguments = [&TRACK[..], &["--config", "amcl.yaml"]].concat();
    let output = replay(&folder, &arguments);
    assert!(output.status.success());
    let warnings = String::from_utf8(output.stderr).unwrap();
    assert_eq!(warnings, "warning: amcl.yaml:5: scan_topic: a recording has one laser\n");
    let asked = summary(&folder, &arguments);
    assert_eq!(asked["seed"], 9);
    // Every third scan is an update, 0.25 m apart as they are.
    let used = asked["methods"]["mcl"]["measurements_used"].as_u64().unwrap();
    assert!((20..25).contains(&used), "{used}");
    let set = ["--seed", "3", "--set", "filter.mcl.update_distance=0.1"];
    let changed = summary(&folder, &[&arguments[..], &set].concat());
    assert_eq!(changed["seed"], 3);
    assert!(changed["methods"]["mcl"]["measurements_used"].as_u64().unwrap() > 55);
    // What is off beside the file is switched on by its keys.
    let set = ["--set", "filter.mcl.novelty.distance={}", "--set", "filter.mcl.tempering=false"];
    assert_eq!(summary(&folder, &[&arguments[..], &set].concat())["seed"], 9);
    let error = failure(&folder, &[&arguments[..], &["--set", "odometry.delay_s=1"]].concat());
    assert!(error.contains("expected keys below filter.mcl or start"), "{error}");
}

#[test]
fn what_does_not_fit_is_refused_in_one_line() {
    let folder = folder();
    fs::write(folder.path().join("other.log"), "hello\nworld\n").unwrap();
    let text = corrected();
    fs::write(folder.path().join("cut.log"), &text[..text.len() - 60]).unwrap();
    for (arguments, message) in [
        (
            vec!["raw.log", "--map", "hall.yaml"],
            "raw.log: expected a reference to start from, a start pose (--initial-pose x,y,yaw) or a search",
        ),
        (vec!["hall.log"], "method mcl: expected a map, which hall has not"),
        (vec!["hall.log", "--map", "none.yaml"], "none.yaml: "),
        (
            vec!["hall.log", "--map", "hall.yaml", "--initial-pose", "1,2"],
            "--initial-pose: expected three finite numbers x,y,yaw, got `1,2`",
        ),
        (
            vec!["hall.log", "--map", "hall.yaml", "--initial-pose", "-50,0,0"],
            "hall.log: expected a start pose inside the map, got (-50.000 m",
        ),
        (
            vec!["hall.log", "--map", "hall.yaml", "--kidnap", "100"],
            "hall.log: expected a time of kidnapping above 0 s and up to 31.500 s",
        ),
        (
            vec!["hall.log", "--map", "hall.yaml", "--reference", "hall.yaml"],
            "hall.yaml:1: time: expected a column time_s",
        ),
        (
            vec!["hall.log", "--map", "hall.yaml", "--format", "wean"],
            "hall.log:2: message: expected O or L, got `FLASER`",
        ),
        (vec!["cut.log", "--map", "hall.yaml"], "cut.log:128: "),
        (
            vec!["other.log"],
            "other.log: expected a recording: a bag of ROS, an MCAP file, a folder with Barcodes.dat (mrclam), a file *_Input.txt",
        ),
        (vec!["none.log"], "none.log: "),
        (
            vec!["hall.log", "--format", "plaza", "--odom-delay", "0.1"],
            "--odom-delay: expected a bag of ROS, got another recording",
        ),
        (
            vec!["hall.log", "--format", "mrclam", "--kidnap", "3"],
            "--kidnap: expected a recording with a laser, got one of MRCLAM",
        ),
        (
            vec!["hall.log", "--map", "hall.yaml", "--set", "filter.mcl.particles.max_particles=0"],
            "settings for lasers: max_particles",
        ),
    ] {
        let error = failure(&folder, &arguments);
        assert!(error.contains(message), "{arguments:?}: {error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
}
