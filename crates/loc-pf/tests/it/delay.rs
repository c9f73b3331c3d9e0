//! The delay between odometry and scans.

use crate::robot::{Robot, office};
use loc_core::Pose2;
use loc_core::random::stream;
use loc_maps::RayCaster;
use loc_pf::delay::{DelayEstimate, DelayEstimator, DelaySettings};
use loc_sensors::laser::LaserScan;
use rand_distr::{Distribution, StandardNormal};

/// Period of the scans and of the odometry \[s\].
const SCANS: f64 = 0.1;
const ODOMETRY: f64 = 0.05;

/// A robot that drives and turns by turns, 0.3 m/s and up to 0.9 rad/s, about a clear place of an
/// office. Its odometry turns 2 % too far with 2 % of noise; `delay` has to be added to its stamps.
fn estimate(seed: u64, delay: f64, seconds: f64, turning: f64) -> Option<DelayEstimate> {
    let map = office(seed);
    let start = Robot::new(&map, Robot::laser(), seed).truth;
    let (walls, laser) = (RayCaster::new(&map), Robot::laser());
    let mut rng = stream(seed, "delay");
    let mounting = Pose2::new(0.2, 0.05, 0.5);
    let mut estimator = DelayEstimator::new(DelaySettings::default()).unwrap();
    let (mut truth, mut odometry) = (start, Pose2::new(3.0, -2.0, 3.0));
    let step = 0.01;
    let (mut next_scan, mut next_odometry) = (0.0, 0.0);
    for k in 0..(seconds / step) as usize {
        let t = k as f64 * step;
        if t >= next_scan {
            let scan = laser.scan(&walls, truth * mounting, &mut rng);
            estimator.scan(t, &scan, mounting);
            next_scan += SCANS;
        }
        if t >= next_odometry {
            estimator.odometry(t - delay, odometry);
            next_odometry += ODOMETRY;
        }
        // Forth and back with turns between.
        let phase = (t / 1.5) as i64 % 4;
        let rate = match phase {
            1 => 0.9 * turning,
            3 => -0.7 * turning,
            _ => 0.0,
        };
        let speed = [0.3, 0.0, -0.3, 0.0][phase as usize];
        let z: f64 = StandardNormal.sample(&mut rng);
        truth = truth * Pose2::exp(&(step * nalgebra::Vector3::new(speed, 0.0, rate)));
        let reported = rate * (1.02 + 0.02 * z);
        odometry = odometry * Pose2::exp(&(step * nalgebra::Vector3::new(speed, 0.0, reported)));
    }
    estimator.estimate()
}

#[test]
fn a_delay_put_in_is_found_and_none_where_there_is_none() {
    let mut squares = 0.0;
    let mut count = 0.0;
    for seed in 1..=3 {
        for delay in [0.0, -0.23, -0.1, 0.06, 0.15] {
            let found = estimate(seed, delay, 20.0, 1.0).unwrap();
            let error = found.delay - delay;
            println!("seed {seed} delay {delay}: {found:?}");
            assert!(error.abs() < 0.008, "seed {seed}, {delay}: {found:?}");
            assert!(found.sigma < 0.01, "{found:?}");
            assert_eq!(found.is_significant(), delay.abs() > 0.0, "{found:?}");
            assert!((found.scale - 1.0 / 1.02).abs() < 0.02, "{found:?}");
            squares += (error / found.sigma).powi(2);
            count += 1.0;
        }
    }
    // The deviation is honest: neither far too small nor far too large.
    let mean = squares / count;
    assert!((0.05..4.0).contains(&mean), "{mean}");
}

#[test]
fn without_a_turn_nothing_is_said() {
    assert_eq!(estimate(1, 0.1, 15.0, 0.0), None);
    assert_eq!(DelayEstimator::new(DelaySettings::default()).unwrap().estimate(), None);
}

#[test]
fn what_is_no_input_changes_nothing() {
    let mut estimator = DelayEstimator::new(DelaySettings::default()).unwrap();
    let map = office(1);
    let scan = Robot::new(&map, Robot::laser(), 1).scan();
    let scan = LaserScan { ranges: vec![f64::NAN; scan.ranges.len()], ..scan };
    let wrong = LaserScan { angle_increment: f64::NAN, ..scan.clone() };
    for stamp in [f64::NAN, f64::INFINITY, 1.0, 0.5, 1e300, -1e300] {
        for pose in [Pose2::new(f64::NAN, 0.0, 0.0), Pose2::IDENTITY] {
            estimator.odometry(stamp, pose);
            estimator.scan(stamp, &scan, pose);
            estimator.scan(stamp, &wrong, Pose2::IDENTITY);
        }
    }
    assert_eq!(estimator.estimate(), None);
    let bad = |change: fn(&mut DelaySettings)| {
        let mut settings = DelaySettings::default();
        change(&mut settings);
        DelayEstimator::new(settings).unwrap_err().to_string()
    };
    assert!(bad(|s| s.longest = f64::NAN).contains("longest delay [s]"));
    assert!(bad(|s| s.points = 0).contains("points of a scan"));
    assert!(bad(|s| s.change_of_rate = -1.0).contains("change of the rate of turn"));
}
