//! `loc-sim fit-beam`: the beam model found again in simulated logs, and learned from real ones.

use loc_core::Pose2;
use loc_core::random::stream;
use loc_maps::OccupancyGrid;
use loc_maps::grid::Occupancy;
use loc_maps::grid::io::{self, ImageFormat, Mode};
use loc_maps::worlds::{self, WorldSettings};
use loc_pf::sensor::BeamModelSettings;
use loc_sensors::laser::{LaserFaults, LaserNoise, LaserScanner, LaserSpec};
use rand::RngExt;
use serde_json::Value;
use std::f64::consts::PI;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

fn fit_beam(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_loc-sim"))
        .current_dir(folder)
        .arg("fit-beam")
        .args(arguments)
        .output()
        .unwrap()
}

fn stdout(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn failure(output: &Output) -> String {
    assert_eq!((output.status.code(), output.stdout.as_slice()), (Some(1), &b""[..]));
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn office(folder: &Path, seed: u64, name: &str) -> OccupancyGrid {
    let settings = WorldSettings { width: 240, height: 240, resolution: 0.05, seed };
    let grid = worlds::office(&settings).unwrap().grid;
    io::save(&grid, folder.join(name), ImageFormat::Pgm, Mode::Trinary).unwrap();
    grid
}

/// A log of scans from anywhere in the map: sigma 4 cm, 3 % dropouts, 10 % of the beams stopped
/// anywhere before the wall. The laser's pose is shifted by `off`.
fn log(grid: &OccupancyGrid, scans: usize, off: f64) -> String {
    let spec = LaserSpec {
        angle_min: -0.5 * PI,
        angle_increment: PI / 180.0,
        beams: 181,
        range_min: 0.0,
        range_max: 20.0,
        noise: LaserNoise { sigma: 0.04, sigma_per_m: 0.0 },
        ..LaserSpec::sick_lms100()
    };
    let faults = LaserFaults { dropout: 0.03, erroneous: 0.0, short: 0.1 };
    let laser = LaserScanner { mounting: Pose2::IDENTITY, spec, faults };
    let free: Vec<_> = grid.centers_of(Occupancy::Free).collect();
    let mut rng = stream(1, "log");
    let mut text = String::from("# simulated\nPARAM robot_front_laser_max 20 nohost 0\n");
    for k in 0..scans {
        let at = free[rng.random_range(0..free.len())];
        let pose = Pose2::new(at.x, at.y, rng.random_range(-3.0..3.0));
        let scan = laser.scan(grid, pose, &mut rng);
        let ranges = scan.ranges.iter().map(|range| format!("{:.3} ", range.clamp(0.0, 90.0)));
        let (x, y, theta) = (pose.x + off, pose.y, pose.theta);
        let ranges: String = ranges.collect();
        text += &format!("FLASER 181 {ranges}{x} {y} {theta} 0 0 0 {k} nohost {k}\n");
    }
    text
}

#[test]
fn a_simulated_laser_is_found_again() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    let grid = office(path, 2, "office.yaml");
    fs::write(path.join("drive.log"), log(&grid, 120, 0.0)).unwrap();
    let table = stdout(&fit_beam(path, &["drive.log", "--map", "office.yaml", "--out", "fit"]));
    assert!(table.lines().all(|line| line.len() <= 80) && table.contains("z_short"), "{table}");
    let text = fs::read_to_string(path.join("fit/beam_model.toml")).unwrap();
    let found: BeamModelSettings = toml::from_str(&text).unwrap();
    assert!((found.sigma_hit - 0.04).abs() < 0.003, "{found:?}");
    assert!((found.z_max - 0.03).abs() < 0.01 && (found.z_hit - 0.87).abs() < 0.02, "{found:?}");
    // Stopped evenly before the wall: nearly no fall with the distance.
    assert!((found.z_short - 0.1).abs() < 0.02 && found.lambda_short < 0.1, "{found:?}");
    assert_eq!(found.max_range, 20.0);
    for figure in ["surfaces.svg", "cuts.svg"] {
        let svg = fs::read_to_string(path.join("fit").join(figure)).unwrap();
        roxmltree::Document::parse(&svg).unwrap();
        assert!(svg.contains("measured") && svg.contains("fitted beam model"));
    }

    let arguments = ["drive.log", "--map", "office.yaml", "--json", "--scans", "odd"];
    let summary: Value = serde_json::from_str(&stdout(&fit_beam(path, &arguments))).unwrap();
    assert_eq!((&summary["scans"], &summary["converged"]), (&60.into(), &true.into()));
    let gains: Vec<f64> = serde_json::from_value(summary["log_likelihoods"].clone()).unwrap();
    assert!(gains.len() > 2 && gains.is_sorted());
    assert!(summary["within_0.1_m"].as_f64().unwrap() > 0.8);
    assert!(path.join("out/fit-beam/summary.json").is_file());
}

#[test]
fn what_does_not_fit_together_is_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    let grid = office(path, 2, "office.yaml");
    office(path, 7, "other.yaml");
    fs::write(path.join("drive.log"), log(&grid, 40, 0.0)).unwrap();
    fs::write(path.join("away.log"), log(&grid, 40, 100.0)).unwrap();
    fs::write(path.join("empty.log"), "# nothing\n").unwrap();
    let short = "FLASER 3 1.0 1.1 1.2 5.0 5.0 0.0 0 0 0 0 nohost 0\n";
    fs::write(path.join("short.log"), short).unwrap();
    fs::write(path.join("broken.log"), "FLASER 3 1.0 x\n").unwrap();
    for (log, map, message) in [
        ("none.log", "office.yaml", "error: none.log: No such file"),
        ("drive.log", "none.yaml", "error: none.yaml: No such file"),
        ("empty.log", "office.yaml", "error: empty.log: expected laser scans, got none"),
        ("broken.log", "office.yaml", "error: broken.log:1: range: expected a finite number"),
        ("away.log", "office.yaml", "error: away.log: expected laser poses in the free space of"),
        ("drive.log", "other.yaml", "error: drive.log: expected "),
        ("short.log", "office.yaml", "error: pairs of an expected and a measured range within"),
    ] {
        let error = failure(&fit_beam(path, &[log, "--map", map, "--out", "x"]));
        assert!(error.starts_with(message) && error.lines().count() == 1, "{error}");
    }
    for (option, value) in
        [("--bin", "0"), ("--max-range", "-1"), ("--bin", "NaN"), ("--max-range", "NaN")]
    {
        let option = format!("{option}={value}");
        failure(&fit_beam(path, &["drive.log", "--map", "office.yaml", "--out", "x", &option]));
    }
    assert!(!path.join("x").exists());
}

/// Real lasers in the maps that were built of them; odd scans before the map of the even ones.
#[test]
fn real_logs_are_learned_from() {
    let Some(carmen) = std::env::var_os("LOC_DATA_DIR").map(|data| Path::new(&data).join("carmen"))
    else {
        return println!("skipped: LOC_DATA_DIR is not set");
    };
    let folder = TempDir::new().unwrap();
    for (log, map, scans) in
        [("intel.log", "intel_even.yaml", "odd"), ("belgioioso.log.gz", "belgioioso.yaml", "all")]
    {
        let (log, map) = (carmen.join(log), carmen.join(map));
        let (log, map) = (log.to_str().unwrap(), map.to_str().unwrap());
        let arguments = [log, "--map", map, "--scans", scans, "--json"];
        let output = stdout(&fit_beam(folder.path(), &arguments));
        let summary: Value = serde_json::from_str(&output).unwrap();
        let fitted = &summary["fitted"];
        assert!(fitted["z_hit"].as_f64().unwrap() > 0.85, "{summary}");
        assert!((0.03..0.12).contains(&fitted["sigma_hit"].as_f64().unwrap()), "{summary}");
        assert!((0.0..0.05).contains(&summary["offset_m"].as_f64().unwrap()), "{summary}");
        assert!(summary["converged"].as_bool().unwrap());
    }
    let (log, map) = (carmen.join("intel.log"), carmen.join("freiburg-079.yaml"));
    let (log, map) = (log.to_str().unwrap(), map.to_str().unwrap());
    let error = failure(&fit_beam(folder.path(), &[log, "--map", map]));
    assert!(error.contains("another map?"), "{error}");
}
