//! The command `loc-sim replay`, and methods, over recordings with a laser.

use super::*;
use loc_maps::grid::io;
use loc_maps::grid::io::{ImageFormat, Mode};
use loc_sim::localizer::{Method, MethodSettings};
use loc_sim::metrics::{Alignment, Summary};
use loc_sim::record::Run;
use loc_sim::runner;
use loc_sim::source::laser_log::{Scans, Start};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::Arc;
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
    // The start of the odometry is unknown in the raw log.
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
        "start_sigma.heading=1",
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
    // The jump of the kidnapping does not count.
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
    let error = failure(&folder, &[&arguments[..], &["--set", "odometry.delay=1"]].concat());
    assert!(error.contains("odometry: expected a calibration for MRCLAM alone"), "{error}");
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
            "settings for lasers: KldSettings.max_particles",
        ),
    ] {
        let error = failure(&folder, &arguments);
        assert!(error.contains(message), "{arguments:?}: {error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
}

fn options() -> ReplayOptions {
    let start_sigmas = [0.2, 0.2, 0.1];
    ReplayOptions { map: Some(Arc::new(hall())), start_sigmas, ..Default::default() }
}

fn run(text: &str, options: &ReplayOptions, global: bool) -> (Run, Summary) {
    let mut source = open(text, options).unwrap();
    let settings = MethodSettings { global, seed: 1, ..Default::default() };
    let methods = [Method::DeadReckoning, Method::Mcl];
    let run = runner::run(&mut source, &methods, &settings, &mut |_| {}).unwrap();
    let summary = Summary::of(&run, None, Alignment::None).unwrap();
    (run, summary)
}

#[test]
fn dead_reckoning_is_the_odometry_transformed_into_the_map() {
    let (run, summary) = run(&corrected(), &options(), false);
    let (truth, odometry) = (drive(), odometry(&drive()));
    for (k, estimate) in run.methods[0].estimates.iter().enumerate() {
        let expected = truth[0] * odometry[0].between(odometry[k]);
        assert!(estimate.pose.distance(expected) < 1e-9, "{k}");
    }
    let sigma = |k: usize| run.methods[0].estimates[k].covariance.unwrap().m22.sqrt();
    assert!((sigma(0) - 0.2).abs() < 1e-12 && sigma(63) > sigma(20) && sigma(20) > 0.2);
    let nees = summary.methods[0].1.nees_mean.unwrap();
    assert!((0.01..3.0).contains(&nees), "{nees}");
}

#[test]
fn mcl_keeps_to_the_truth_where_odometry_does_not() {
    let (_, summary) = run(&corrected(), &options(), false);
    let error = |k: usize| summary.methods[k].1.errors.unwrap();
    assert!(error(0).final_error_m > 0.8, "{:?}", error(0));
    assert!(error(1).ate_rmse_m < 0.1 && error(1).final_error_m < 0.15, "{:?}", error(1));
    let mcl = &summary.methods[1].1;
    assert!(mcl.measurements_used > 55 && mcl.converged_at_s.is_none());
    assert_eq!((summary.duration_s, mcl.recovered_after_s), (31.5, None));
}

#[test]
fn without_a_truth_every_figure_of_errors_is_null() {
    let start = Start::At(drive()[0]);
    let (run, summary) = run(&uncorrected(), &ReplayOptions { start, ..options() }, false);
    // The estimates are those at the scans.
    assert_eq!((run.stamps.len(), run.truth.len()), (64, 0));
    assert_eq!((run.stamps[0], run.stamps[63]), (50.0, 81.5));
    assert!(run.methods.iter().all(|record| record.estimates.len() == 64));
    let json = serde_json::to_value(&summary).unwrap();
    assert!(json["distance_m"].is_null() && json["duration_s"] == 31.5);
    let judged = loc_sim::metrics::PlanarErrors::NAMES.into_iter().chain(["nees_mean"]);
    for name in judged.chain(["converged_at_s", "recovered_after_s"]) {
        let figure = json["methods"]["mcl"].get(name);
        assert!(figure.is_some_and(serde_json::Value::is_null), "{name}: {figure:?}");
    }
    let files = loc_sim::output::files(&run, &summary, "hall", "loc-sim").unwrap();
    let names: Vec<&str> = files.names().collect();
    assert!(names.contains(&"estimate_mcl.tum") && names.contains(&"map.svg"), "{names:?}");
    assert!(!names.contains(&"truth.tum") && !names.contains(&"errors.svg"), "{names:?}");
    assert_eq!(files.text("estimate_mcl.tum").unwrap().lines().count(), 65);
    let table = loc_sim::output::table(&summary);
    assert!(table.starts_with("hall: 31.5 s\n") && table.lines().all(|l| l.len() <= 80), "{table}");
    assert!(table.contains("\nmcl: 100.0 % of the last scan's beams"), "{table}");
    assert_eq!(json["methods"]["mcl"]["beam_fit_at_end"], 1.0);
    // The estimates are sound all the same.
    let last = run.methods[1].estimates[63].pose;
    assert!(last.distance(drive()[63]) < 0.15, "{last}");
}

#[test]
fn names_of_the_errors_are_those_that_are_written() {
    let (_, summary) = run(&corrected(), &options(), false);
    let errors = serde_json::to_value(summary.methods[0].1.errors.unwrap()).unwrap();
    let names: Vec<&str> = errors.as_object().unwrap().keys().map(String::as_str).collect();
    let mut known = loc_sim::metrics::PlanarErrors::NAMES;
    known.sort_unstable();
    assert_eq!(names, known);
}

#[test]
fn a_map_is_needed_and_free_space_in_it() {
    let start = |map| {
        let mut source = open(&corrected(), &ReplayOptions { map, ..options() }).unwrap();
        let settings = MethodSettings::default();
        runner::run(&mut source, &[Method::Mcl], &settings, &mut |_| {}).unwrap_err().to_string()
    };
    assert_eq!(start(None), "method mcl: expected a map, which hall has not");
    let walls = OccupancyGrid::filled(*hall().frame(), 100);
    assert_eq!(
        start(Some(Arc::new(walls))),
        "map of 200 x 60 cells: expected free cells, got none"
    );
}

#[test]
fn intel_is_tracked_on_the_scans_that_its_map_has_not_seen() {
    let Some(folder) = std::env::var_os("LOC_DATA_DIR") else {
        println!("skipped: LOC_DATA_DIR is not set");
        return;
    };
    let folder = Path::new(&folder).join("carmen");
    let map = loc_maps::grid::io::load(folder.join("intel_even.yaml")).unwrap();
    let options = ReplayOptions { map: Some(Arc::new(map)), scans: Scans::Odd, ..options() };
    let text = std::fs::read_to_string(folder.join("intel.log")).unwrap();
    let (run, summary) = run(&text, &options, false);
    assert_eq!((run.truth.len(), run.duration().round()), (455, 2649.0));
    let errors = |k: usize| summary.methods[k].1.errors.unwrap();
    // Raw odometry ends 61.8 m off.
    assert!((errors(0).final_error_m - 61.7).abs() < 0.5, "{:?}", errors(0));
    assert!(errors(1).ate_rmse_m < 0.5 && errors(1).ate_median_m < 0.045, "{:?}", errors(1));
}
