//! `loc-sim map`, and maps built from real logs.

use loc_maps::grid::{Occupancy, io};
use loc_maps::{LineMap, PointMap, TopologicalMap};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

fn map(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_loc-sim"))
        .current_dir(folder)
        .arg("map")
        .args(arguments)
        .output()
        .unwrap()
}

fn stdout(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn failure(folder: &Path, arguments: &[&str]) -> String {
    let output = map(folder, arguments);
    assert_eq!((output.status.code(), output.stdout.as_slice()), (Some(1), &b""[..]));
    String::from_utf8(output.stderr).unwrap()
}

fn data(file: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("LOC_DATA_DIR");
    if folder.is_none() {
        println!("skipped: LOC_DATA_DIR is not set");
    }
    folder.map(|folder| Path::new(&folder).join(file))
}

#[test]
fn a_made_world_is_looked_at_and_converted() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    stdout(&map(path, &["make", "office", "--size", "400", "--seed", "3", "--out", "o"]));
    let info = stdout(&map(path, &["info", "o/office.yaml", "--width", "50"]));
    assert!(
        info.starts_with("size        400 x 400 cells, 20.00 m x 20.00 m\nresolution  0.05 m\n")
    );
    assert!(info.lines().skip(6).all(|line| line.chars().count() == 50), "{info}");

    for (out, kind) in
        [("w.csv", "lines"), ("p.csv", "points"), ("r.toml", "lines"), ("m.svg", "lines")]
    {
        stdout(&map(path, &["convert", "o/office.yaml", out, "--to", kind]));
    }
    let lines = LineMap::read_csv(path.join("w.csv")).unwrap();
    let points = PointMap::read_csv(path.join("p.csv")).unwrap();
    assert!(lines.len() > 20 && points.len() > 1000);
    assert!(TopologicalMap::read_toml(path.join("r.toml")).unwrap().places().len() > 3);
    assert!(
        stdout(&map(path, &["info", "w.csv"])).starts_with(&format!("{} lines, from", lines.len()))
    );
    assert!(stdout(&map(path, &["info", "p.csv", "--json"])).contains("\"kind\": \"points\""));

    for image in ["pgm", "png", "bmp"] {
        stdout(&map(path, &["convert", "o/office.yaml", "again.yaml", "--image", image]));
        let (a, b) = (io::load(path.join("o/office.yaml")), io::load(path.join("again.yaml")));
        assert_eq!(a.unwrap(), b.unwrap());
    }
    stdout(&map(path, &["convert", "w.csv", "walls.yaml", "--resolution", "0.1"]));
    assert_eq!(io::load(path.join("walls.yaml")).unwrap().resolution(), 0.1);
}

#[test]
fn worlds_come_by_name_and_seed() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    for world in ["corridor", "hall-of-mirrors", "soccer-field", "office"] {
        stdout(&map(path, &["make", world, "--out", world]));
        assert!(path.join(world).join(format!("{world}.yaml")).is_file());
    }
    assert!(path.join("soccer-field/landmarks.csv").is_file());
    let pgm = |seed: &str| {
        stdout(&map(path, &["make", "office", "--size", "300", "--seed", seed, "--out", "o"]));
        fs::read(path.join("o/office.pgm")).unwrap()
    };
    assert!(pgm("1") == pgm("1") && pgm("1") != pgm("2"));
}

#[test]
fn mistakes_are_reported_in_one_line() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    fs::write(path.join("zero.yaml"), "image: a.pgm\nresolution: 0\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n").unwrap();
    fs::write(path.join("empty.log"), "# nothing\n").unwrap();
    for (arguments, message) in [
        (&["info", "none.yaml"][..], "error: none.yaml: No such file or directory"),
        (&["info", "zero.yaml"], "error: zero.yaml: "),
        (&["build", "empty.log", "--out", "b"], "error: empty.log: expected laser scans, got none"),
        (&["convert", "zero.yaml", "x.svg"], "error: zero.yaml: "),
        (&["make", "office", "--size", "10", "--out", "b"], "error: "),
        (&["make", "office", "--resolution", "-1", "--out", "b"], "error: "),
    ] {
        let error = failure(path, arguments);
        assert!(error.starts_with(message) && error.lines().count() == 1, "{error}");
    }
    assert!(!path.join("b").exists());
}

/// The grid built at the reference poses against the one that lies beside the log.
#[test]
fn intel_is_mapped_as_the_reference_has_it() {
    let Some(carmen) = data("carmen") else { return };
    let folder = TempDir::new().unwrap();
    let like = carmen.join("intel.yaml");
    let log = carmen.join("intel.log");
    let arguments =
        ["build", log.to_str().unwrap(), "--out", "b", "--like", like.to_str().unwrap()];
    stdout(&map(folder.path(), &arguments));
    let (ours, theirs) =
        (io::load(folder.path().join("b/map.yaml")).unwrap(), io::load(&like).unwrap());
    let classes = theirs.iter().map(|(cell, value)| (ours.occupancy(cell), Occupancy::of(value)));
    let known = |class: &Occupancy| *class != Occupancy::Unknown;
    let both: Vec<_> = classes.filter(|(a, b)| known(a) && known(b)).collect();
    let agree = both.iter().filter(|(a, b)| a == b).count() as f64 / both.len() as f64;
    let walls = both.iter().filter(|(_, b)| *b == Occupancy::Occupied);
    let found = walls.clone().filter(|(a, _)| *a == Occupancy::Occupied).count() as f64;
    let found = found / walls.count() as f64;
    println!(
        "{} cells known in both, {:.2} % agree, {:.1} % of the walls",
        both.len(),
        100.0 * agree,
        100.0 * found
    );
    assert!(both.len() > 150_000 && agree >= 0.97 && found > 0.8, "{agree} {found}");
    assert!(PointMap::read_csv(folder.path().join("b/scan_map.csv")).unwrap().len() > 10_000);
}
