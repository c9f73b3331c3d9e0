//! The lost figure on a real robot: the Intel laboratory, every odd scan in the map of the even
//! ones, at the pose of the reference track and at wrong ones.

use loc_core::Pose2;
use loc_core::random::stream;
use loc_maps::grid::io;
use loc_pf::confidence::{LostMonitor, LostSettings, ScanRater};
use loc_pf::mcl::MountedScan;
use loc_sensors::laser::LaserScan;
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;

/// The odd scans of a log with 180 beams over half a turn, with their reference poses.
fn odd_scans(log: &str) -> Vec<(Pose2, LaserScan)> {
    let scan = |line: &str| {
        let numbers: Vec<f64> =
            line.split_whitespace().skip(1).map(|word| word.parse().unwrap_or(f64::NAN)).collect();
        let beams = numbers[0] as usize;
        let (ranges, pose) = numbers[1..].split_at(beams);
        let angle_increment = PI / beams as f64;
        let scan = LaserScan {
            angle_min: -FRAC_PI_2,
            angle_max: FRAC_PI_2 - angle_increment,
            angle_increment,
            time_increment: 0.0,
            scan_time: 0.1,
            range_min: 0.05,
            range_max: 40.0,
            ranges: ranges.to_vec(),
            intensities: Vec::new(),
        };
        (Pose2::new(pose[0], pose[1], pose[2]), scan)
    };
    log.lines().filter(|line| line.starts_with("FLASER ")).skip(1).step_by(2).map(scan).collect()
}

#[test]
fn a_real_robot_is_told_right_from_lost() {
    let Some(folder) = std::env::var_os("LOC_DATA_DIR") else {
        println!("LOC_DATA_DIR is not set: the Intel recording is left out");
        return;
    };
    let folder = Path::new(&folder).join("carmen");
    let map = io::load(folder.join("intel_even.yaml")).unwrap();
    let scans = odd_scans(&std::fs::read_to_string(folder.join("intel.log")).unwrap());
    let mut rater = ScanRater::new(&map, &mut stream(1, "poses")).unwrap();
    // Shares of the updates that say less than 0.05 and more than 0.9.
    let mut said = |reported: &dyn Fn(usize) -> Pose2| {
        let mut monitor = LostMonitor::new(LostSettings::default()).unwrap();
        let mut counts = [0.0; 2];
        let updates: Vec<usize> = (0..scans.len()).step_by(4).collect();
        for &k in &updates {
            let scans = [MountedScan { scan: &scans[k].1, mounting: Pose2::IDENTITY }];
            let said = monitor.update(rater.rate(reported(k), &scans), 1.0);
            counts[0] += f64::from(u8::from(said < 0.05)) / updates.len() as f64;
            counts[1] += f64::from(u8::from(said > 0.9)) / updates.len() as f64;
        }
        counts
    };
    let right = said(&|k| scans[k].0);
    let aside = said(&|k| scans[k].0 * Pose2::new(0.7, 0.7, 0.0));
    let elsewhere = said(&|k| scans[(k + scans.len() / 3) % scans.len()].0);
    println!("below 0.05 and above 0.9: right {right:?}, aside {aside:?}, elsewhere {elsewhere:?}");
    assert!(right[0] > 0.9 && right[1] < 0.005);
    assert!(aside[1] > 0.98 && elsewhere[1] > 0.98);
}
