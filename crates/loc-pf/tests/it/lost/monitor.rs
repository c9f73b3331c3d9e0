//! The parts of the lost figure, by hand.

use approx::assert_abs_diff_eq;
use loc_core::Pose2;
use loc_core::random::stream;
use loc_maps::OccupancyGrid;
use loc_maps::grid::{Cell, GridFrame};
use loc_pf::Particles;
use loc_pf::confidence::{LostMonitor, LostSettings, ScanFit, ScanRater, Tolerance};
use loc_pf::mcl::MountedScan;
use loc_sensors::laser::LaserScan;
use std::f64::consts::{FRAC_PI_2, PI};

fn settings() -> LostSettings {
    LostSettings::default()
        .memory(0.5)
        .bias(1.0)
        .margin_weight(2.0)
        .blocked_weight(3.0)
        .near_weight(0.5)
        .support_exponent(2.0)
}

fn logistic(odds: f64) -> f64 {
    1.0 / (1.0 + (-odds).exp())
}

#[test]
fn two_updates_by_hand() {
    let mut monitor = LostMonitor::new(settings()).unwrap();
    // Mean 0.4, best 0.6: better by 0.3 of 0.6. ln(1 + 0.02 / 0.02) = ln 2, ln(1 + 0.06 / 0.02) = ln 4.
    let scan = ScanFit { here: 0.9, elsewhere: &[0.2, 0.4, 0.6], blocked: 0.02, near: 0.06 };
    let shift = 1.0 - 2.0 * 0.5 + 3.0 * 2_f64.ln() + 0.5 * 4_f64.ln();
    let right = 1.0 - logistic(shift);
    assert_abs_diff_eq!(monitor.update(Some(scan), 0.8), 1.0 - right * 0.64, epsilon = 1e-12);
    let right = 1.0 - logistic(1.5 * shift);
    assert_abs_diff_eq!(monitor.update(Some(scan), 1.0), 1.0 - right, epsilon = 1e-12);
    // No scan, no news; only the support is another.
    assert_abs_diff_eq!(monitor.update(None, 0.5), 1.0 - right * 0.25, epsilon = 1e-12);
    assert_eq!(monitor.probability(), monitor.update(None, 0.5));
}

#[test]
fn a_restart_forgets_and_fades() {
    let mut monitor = LostMonitor::new(settings()).unwrap();
    for wrong in [0.0, 0.2, 1.0] {
        monitor.restart(wrong).unwrap();
        assert_abs_diff_eq!(monitor.update(None, 1.0), wrong, epsilon = 1e-5);
    }
    let scan = ScanFit { here: 0.7, elsewhere: &[0.7], blocked: 0.0, near: 0.0 };
    let said: Vec<f64> = (0..60).map(|_| monitor.update(Some(scan), 1.0)).collect();
    assert_abs_diff_eq!(said[59], logistic(2.0), epsilon = 1e-9);
    assert!(monitor.restart(1.5).is_err() && monitor.restart(f64::NAN).is_err());
}

#[test]
fn what_is_no_number_says_nothing() {
    let mut monitor = LostMonitor::new(settings()).unwrap();
    let bad = [f64::NAN, f64::INFINITY, -1e300, 1e300];
    for here in bad {
        for blocked in bad {
            for elsewhere in [&[f64::NAN][..], &[1e300, f64::INFINITY], &[], &[1.0, 1.0]] {
                for support in bad {
                    let scan = ScanFit { here, elsewhere, blocked, near: blocked };
                    let said = monitor.update(Some(scan), support);
                    assert!((0.0..=1.0).contains(&said), "{said}");
                }
            }
        }
    }
    monitor.restart(0.5).unwrap();
    assert_eq!(monitor.update(None, f64::NAN), 1.0);
}

#[test]
fn settings_out_of_range_are_refused() {
    let good = LostSettings::default();
    assert!(good.check().is_ok());
    let tolerance = |distance, turn| Tolerance::default().distance(distance).turn(turn);
    for bad in [
        good.memory(1.0),
        good.memory(-0.1),
        good.bias(f64::NAN),
        good.margin_weight(-1.0),
        good.near_weight(f64::NAN),
        good.support_exponent(f64::INFINITY),
        good.tolerance(tolerance(0.0, 0.1)),
        good.tolerance(tolerance(0.5, -1.0)),
    ] {
        assert!(LostMonitor::new(bad).is_err(), "{bad:?}");
    }
}

#[test]
fn support_is_the_weight_within_the_tolerance() {
    let mut cloud = Particles::new();
    let reported = Pose2::new(1.0, 2.0, PI - 0.1);
    for (x, y, theta, weight) in [
        (1.0, 2.0, PI - 0.1, 0.1_f64),
        (1.3, 2.4, -PI + 0.1, 0.2), // 0.5 m away, turned by 0.2 across pi
        (1.31, 2.4, PI - 0.1, 0.3), // a little too far
        (1.0, 2.0, PI - 0.4, 0.15), // turned too far
        (f64::NAN, 2.0, PI, 0.25),
    ] {
        cloud.push(Pose2 { x, y, theta }, weight.ln());
    }
    assert_abs_diff_eq!(Tolerance::default().support(&cloud, reported), 0.3, epsilon = 1e-9);
    assert_eq!(Tolerance::default().support(&Particles::new(), reported), 0.0);
}

/// A room of 8 m x 8 m with a wall at x = 6 m.
fn room() -> OccupancyGrid {
    let mut grid =
        OccupancyGrid::filled(GridFrame::new(160, 160, 0.05, Pose2::IDENTITY).unwrap(), 0);
    (0..160).for_each(|row| grid.set(Cell::new(120, row), 100).unwrap());
    grid
}

#[test]
fn beams_are_blocked_by_the_walls_they_pass() {
    let room = room();
    let mut rater = ScanRater::new(&room, &mut stream(1, "poses")).unwrap();
    // Four beams of a laser that looks left and sits 0.5 m ahead of the middle: to the right of
    // the laser is ahead of the robot.
    let scan = LaserScan {
        angle_min: -FRAC_PI_2 - 0.02,
        angle_max: -FRAC_PI_2 + 0.04,
        angle_increment: 0.02,
        time_increment: 0.0,
        scan_time: 0.1,
        range_min: 0.1,
        range_max: 10.0,
        ranges: vec![2.5, 2.5, 2.5, f64::INFINITY],
        intensities: Vec::new(),
    };
    let mounting = Pose2::new(0.5, 0.0, FRAC_PI_2);
    let scans = [MountedScan { scan: &scan, mounting }];
    let mut fit = |x: f64| {
        let fit = rater.rate(Pose2::new(x, 4.0, 0.0), &scans).unwrap();
        assert_eq!(fit.elsewhere.len(), ScanRater::POSES);
        (fit.here, fit.blocked)
    };
    let (right, blocked) = fit(3.0);
    assert!(right > 0.98 && blocked == 0.0);
    let (through, blocked) = fit(3.6);
    assert!(through < 0.6 && blocked == 1.0);
    let (short, blocked) = fit(2.4);
    assert!(short < 0.6 && blocked == 0.0);

    let silent = LaserScan { ranges: vec![f64::NAN; 4], ..scan.clone() };
    let nothing = [MountedScan { scan: &silent, mounting }];
    assert!(rater.rate(Pose2::new(3.0, 4.0, 0.0), &nothing).is_none());
    assert!(rater.rate(Pose2::new(3.0, 4.0, 0.0), &[]).is_none());
    let nowhere = Pose2 { x: f64::NAN, y: 0.0, theta: 0.0 };
    let lost = rater.rate(nowhere, &scans).unwrap();
    assert!(lost.here < 0.01);
    let mut walls = room.clone();
    for cell in (0..160 * 160).map(|k| Cell::new(k % 160, k / 160)) {
        walls.set(cell, 100).unwrap();
    }
    assert!(ScanRater::new(&walls, &mut stream(1, "poses")).is_err());
}
