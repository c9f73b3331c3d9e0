//! "Am I lost?": whether the stated probability is true.

mod calibration;
mod fitting;
mod monitor;
mod recorded;
mod simulation;

use crate::robot::{self, Robot};
use calibration::{calibration_error, print, reliability, statements};
use loc_core::random::stream;
use loc_maps::OccupancyGrid;
use loc_maps::grid::{Cell, Occupancy};
use loc_maps::worlds::{self, WorldSettings};
use loc_pf::confidence::{LostMonitor, LostSettings};
use loc_sensors::laser::{LaserFaults, LaserScanner, LaserSpec};
use rand::RngExt;
use simulation::{Conditions, Sample, drives};

fn office(width: usize, height: usize, seed: u64) -> OccupancyGrid {
    let settings = WorldSettings { width, height, resolution: 0.05, seed };
    worlds::office(&settings).unwrap().grid
}

/// The laser among people who stand in the way of a share of its beams.
fn people(laser: LaserScanner, share: f64) -> LaserScanner {
    LaserScanner { faults: LaserFaults { short: share, ..LaserFaults::NONE }, ..laser }
}

/// The building after some boxes of 0.6 m have come and as many places were cleared.
fn changed(map: &OccupancyGrid, boxes: usize, seed: u64) -> OccupancyGrid {
    let mut building = map.clone();
    let mut rng = stream(seed, "boxes");
    let side = 12;
    for number in 0..2 * boxes {
        let column = rng.random_range(20..map.width() - 20 - side);
        let row = rng.random_range(20..map.height() - 20 - side);
        for cell in (0..side * side).map(|k| Cell::new(column + k % side, row + k / side)) {
            if building.occupancy(cell) != Occupancy::Unknown {
                building.set(cell, if number % 2 == 0 { 100 } else { 0 }).unwrap();
            }
        }
    }
    building
}

/// An office, a laser and a filter that the constants were not fitted to.
fn unseen(seed: u64, short: f64, boxes: usize) -> Conditions {
    let map = office(500, 500, 20 + seed);
    Conditions {
        building: changed(&map, boxes, seed),
        map,
        laser: people(LaserScanner::new(LaserSpec::hokuyo_ust_10lx()).unwrap(), short),
        beams: 45,
        particles: 500,
        updates: 40,
        exponent: 0.4,
        injected: 0.01,
    }
}

/// Shares of short beams and boxes moved: the mixture of the fit in other buildings, by another
/// laser.
const MIXTURE: [(f64, usize); 5] = [(0.0, 0), (0.1, 10), (0.2, 20), (0.3, 5), (0.4, 30)];

#[test]
fn stated_probabilities_are_true() {
    let surroundings = MIXTURE.into_iter().enumerate();
    let few = |(k, (short, boxes)): (usize, (f64, usize))| {
        let seed = 50 + k as u64;
        drives(&unseen(seed, short, boxes), 5, seed)
    };
    let drives: Vec<_> = surroundings.flat_map(few).collect();
    let bars = reliability(&statements(LostSettings::default(), &drives));
    print(&bars);
    assert!(calibration_error(&bars) < 0.05);
    assert!(bars[0].count > 300 && bars[9].count > 300, "it must commit itself");
}

#[test]
#[ignore = "the same over many more drives: ten seconds in release mode, prints the diagrams"]
fn stated_probabilities_are_true_over_many_drives() {
    let mut all = Vec::new();
    for (k, (short, boxes)) in MIXTURE.into_iter().cycle().take(20).enumerate() {
        let seed = 1000 + k as u64;
        let conditions = Conditions { particles: 1500, updates: 60, ..unseen(seed, short, boxes) };
        all.push(drives(&conditions, 10, seed));
    }
    for (k, (short, boxes)) in MIXTURE.into_iter().enumerate() {
        let part: Vec<_> = all.iter().skip(k).step_by(MIXTURE.len()).flatten().cloned().collect();
        println!("{short} of the beams short, {boxes} boxes moved");
        print(&reliability(&statements(LostSettings::default(), &part)));
    }
    let all: Vec<_> = all.into_iter().flatten().collect();
    let bars = reliability(&statements(LostSettings::default(), &all));
    println!("together");
    print(&bars);
    assert!(calibration_error(&bars) < 0.05);
    for bar in bars.iter().filter(|bar| bar.count >= 500) {
        assert!((bar.stated - bar.lost).abs() < 0.15, "{bar:?}");
    }
}

/// What a monitor says in each update of a drive.
fn said(drive: &[Sample]) -> Vec<f64> {
    let mut monitor = LostMonitor::new(LostSettings::default()).unwrap();
    drive.iter().map(|sample| monitor.update(sample.scan(), sample.support)).collect()
}

#[test]
fn a_kidnapped_robot_says_so_and_a_tracking_one_is_sure() {
    let map = robot::office(9);
    let conditions = Conditions {
        building: map.clone(),
        map,
        laser: Robot::laser(),
        beams: 60,
        particles: 400,
        updates: 40,
        exponent: 0.3,
        injected: 0.0,
    };
    let drives = drives(&conditions, 10, 77);
    let (mut tracked, mut sure) = (0, 0);
    let mut alarmed = Vec::new();
    for drive in &drives {
        let said = said(drive);
        for (sample, &said) in drive.iter().zip(&said).skip(5).filter(|(sample, _)| !sample.lost) {
            (tracked, sure) = (tracked + 1, sure + usize::from(said < 0.05));
            assert!(sample.support <= 1.0);
        }
        let gone = drive.iter().position(|sample| sample.since_kidnapping == Some(0));
        alarmed.extend(gone.map(|gone| said[gone..].iter().position(|&said| said > 0.9)));
    }
    println!("sure in {sure} of {tracked} updates; alarm after {alarmed:?} updates");
    assert!(tracked > 400 && sure as f64 > 0.97 * tracked as f64);
    let in_time = alarmed.iter().filter(|after| after.is_some_and(|after| after <= 5)).count();
    assert!(alarmed.len() == 10 && in_time >= 9);
}
