//! Where the constants of `LostSettings` come from.

use super::calibration::{log_loss, print, reliability, statements};
use super::simulation::{Conditions, Sample, drives};
use super::{changed, office, people};
use crate::robot::Robot;
use loc_pf::confidence::LostSettings;
use loc_sensors::laser::{LaserScanner, LaserSpec};
use std::f64::consts::PI;

/// The constants as numbers that may have any value.
fn decode(numbers: &[f64; 6]) -> LostSettings {
    let [memory, bias, margin, blocked, near, support] = *numbers;
    LostSettings::default()
        .memory(1.0 / (1.0 + (-memory).exp()))
        .bias(bias)
        .margin_weight(margin.abs())
        .blocked_weight(blocked.abs())
        .near_weight(near.abs())
        .support_exponent(support.abs())
}

/// Least value of a function by the simplex method of Nelder and Mead (1965).
fn minimize(start: [f64; 6], cost: impl Fn(&[f64; 6]) -> f64) -> ([f64; 6], f64) {
    let mut simplex = vec![(start, cost(&start))];
    for k in 0..6 {
        let mut corner = start;
        corner[k] += 0.5 + 0.1 * corner[k].abs();
        simplex.push((corner, cost(&corner)));
    }
    for _ in 0..600 {
        simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
        let (worst, rest) = simplex.split_last().unwrap();
        let center: [f64; 6] =
            std::array::from_fn(|k| rest.iter().map(|(x, _)| x[k]).sum::<f64>() / 6.0);
        let at = |step: f64| {
            let x = std::array::from_fn(|k| center[k] + step * (center[k] - worst.0[k]));
            (x, cost(&x))
        };
        let reflected = at(1.0);
        let better = if reflected.1 < simplex[0].1 {
            let expanded = at(2.0);
            if expanded.1 < reflected.1 { expanded } else { reflected }
        } else if reflected.1 < simplex[5].1 {
            reflected
        } else {
            at(-0.5)
        };
        if better.1 < worst.1 {
            simplex[6] = better;
        } else {
            let best = simplex[0].0;
            for corner in &mut simplex[1..] {
                corner.0 = std::array::from_fn(|k| 0.5 * (corner.0[k] + best[k]));
                corner.1 = cost(&corner.0);
            }
        }
    }
    simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
    simplex[0]
}

/// Surroundings: share of the beams that people shorten, boxes that came and went in an office of
/// 600 m^2; and filters: power of the likelihood, share of injected particles, their number.
const SURROUNDINGS: [(f64, usize, f64, f64, usize); 8] = [
    (0.0, 0, 0.3, 0.0, 1000),
    (0.1, 10, 0.5, 0.01, 2000),
    (0.2, 20, 0.2, 0.02, 1000),
    (0.4, 30, 0.3, 0.05, 2000),
    (0.0, 15, 1.0, 0.0, 500),
    (0.3, 0, 0.2, 0.02, 3000),
    (0.05, 0, 0.1, 0.02, 3000),
    (0.2, 30, 1.0, 0.0, 1000),
];

/// Drives through all of these, in 16 offices of four sizes, with three lasers.
fn training() -> Vec<Vec<Sample>> {
    let lms = LaserSpec::sick_lms100();
    let degree = 1_f64.to_radians();
    let (angle_increment, half_turn) = (degree, -90.0 * degree);
    let all_round =
        LaserSpec { angle_min: -PI, angle_increment, beams: 360, range_max: 30.0, ..lms };
    let ahead =
        LaserSpec { angle_min: half_turn, angle_increment, beams: 181, range_max: 8.0, ..lms };
    let lasers = [Robot::laser().spec, all_round, ahead];
    let sizes = [(600, 400), (500, 500), (800, 600), (400, 300)];
    let mut all = Vec::new();
    for number in 0..16 {
        let (short, boxes, exponent, injected, particles) = SURROUNDINGS[number / 2];
        let seed = 100 + number as u64;
        let (width, height) = sizes[(number / 4 + number) % 4];
        let map = office(width, height, seed);
        let laser = LaserScanner::new(lasers[number % 3]).unwrap();
        let conditions = Conditions {
            building: changed(&map, boxes * width * height / 240_000, seed),
            map,
            laser: people(laser, short),
            beams: 60,
            particles,
            updates: 60,
            exponent,
            injected,
        };
        all.extend(drives(&conditions, 15, seed));
    }
    all
}

#[test]
#[ignore = "the fit itself: a minute in release mode, prints the constants"]
fn fit_the_constants() {
    let drives = training();
    let lost = drives.iter().flatten().filter(|sample| sample.lost).count();
    let updates: usize = drives.iter().map(Vec::len).sum();
    println!("{} drives, lost in {lost} of {updates} updates", drives.len());
    let cost = |numbers: &[f64; 6]| log_loss(&statements(decode(numbers), &drives));
    // Twice, as a simplex may shrink too early.
    let (numbers, _) = minimize([0.0, -3.0, 2.0, 1.0, 1.0, 0.5], cost);
    let (numbers, loss) = minimize(numbers, cost);
    println!("{:#?}\nlog loss {loss:.4}", decode(&numbers));
    print(&reliability(&statements(decode(&numbers), &drives)));
}
