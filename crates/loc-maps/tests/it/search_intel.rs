//! Global search on a recording: a robot in the Intel lab, scans that were not used for the map.

use loc_core::{Pose2, angle};
use loc_maps::LikelihoodField;
use loc_maps::grid::io;
use loc_maps::likelihood_field::{Endpoints, LikelihoodFieldSettings};
use loc_maps::{GlobalSearch, SearchSettings};
use std::path::{Path, PathBuf};

/// A scan's ends and the reference pose of the laser.
type Scan = (Pose2, Endpoints);

fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("LOC_DATA_DIR").map(|folder| Path::new(&folder).join("carmen"));
    if folder.is_none() {
        println!("skipped: LOC_DATA_DIR is not set");
    }
    folder
}

/// Every other scan of the log, the first one left out, with every `thinning`-th beam.
fn odd_scans(folder: &Path, thinning: usize) -> Vec<Scan> {
    let log = std::fs::read_to_string(folder.join("intel.log")).unwrap();
    let lines = log.lines().filter_map(|line| line.strip_prefix("FLASER "));
    let scan = |line: &str| {
        let numbers: Vec<f64> = line.split(' ').map_while(|field| field.parse().ok()).collect();
        let beams = numbers[0] as usize;
        let [x, y, theta] = [1, 2, 3].map(|k| numbers[beams + k]);
        let angle = |k: usize| (k as f64 - 90.0).to_radians();
        let hit = |&k: &usize| numbers[1 + k] < 40.0;
        let end = |k| [numbers[1 + k] * angle(k).cos(), numbers[1 + k] * angle(k).sin()];
        let ends = (0..beams).step_by(thinning).filter(hit).map(end);
        (Pose2::new(x, y, theta), ends.collect())
    };
    lines.skip(1).step_by(2).map(scan).collect()
}

fn search(folder: &Path, step: f64) -> GlobalSearch {
    let map = io::load(folder.join("intel_even.yaml")).unwrap();
    let field = LikelihoodFieldSettings::nav2().max_range(30.0);
    let field = LikelihoodField::new(&map, &field).unwrap();
    let angle_step = step.to_radians();
    GlobalSearch::new(&map, field, SearchSettings { angle_step, ..Default::default() }).unwrap()
}

/// How many places out of how many are right within 0.3 m and 5 deg: the best candidate, and any.
fn right(search: &GlobalSearch, scans: &[Scan], together: usize, every: usize) -> [usize; 3] {
    let mut counts = [0; 3];
    for scans in scans.windows(together).step_by(every) {
        let now = scans[together - 1].0;
        let seen: Vec<(Pose2, &Endpoints)> =
            scans.iter().map(|(pose, ends)| (now.between(*pose), ends)).collect();
        let found = search.search_many(&seen).unwrap();
        let is_right = |pose: Pose2| {
            let turn = angle::difference(pose.theta, now.theta).abs();
            pose.distance(now) < 0.3 && turn < 5_f64.to_radians()
        };
        counts[0] += usize::from(is_right(found[0].pose));
        counts[1] += usize::from(found.iter().any(|found| is_right(found.pose)));
        counts[2] += 1;
    }
    counts
}

#[test]
fn intel_by_two_scans() {
    let Some(folder) = folder() else { return };
    let [best, any, all] = right(&search(&folder, 2.0), &odd_scans(&folder, 3), 2, 57);
    println!("every third beam of two scans: best right {best}, any {any} of {all}");
    assert!(best == all);
}

/// All of the recording, for release builds:
/// `cargo test --release -p loc-maps -- --ignored --nocapture intel`
#[test]
#[ignore = "a minute in a release build"]
fn intel_by_one_two_and_three_scans() {
    let Some(folder) = folder() else { return };
    let (search, scans) = (search(&folder, 1.0), odd_scans(&folder, 1));
    for (together, least) in [(1, 0.95), (2, 0.98), (3, 0.98)] {
        let [best, any, all] = right(&search, &scans, together, 1);
        println!("{together} scans: best right {best}, any {any} of {all}");
        assert!(best as f64 >= least * all as f64);
    }
}
