//! What a grid refuses, and what it makes of odd inputs.

use super::robot::{Robot, office};
use loc_core::gaussian::pose_belief;
use loc_core::{Error as CoreError, Gaussian, Pose2};
use loc_filters::Error;
use loc_filters::histogram::{FineSettings, GridLocalizer, GridSettings, GridUpdate};
use loc_maps::OccupancyGrid;
use loc_maps::grid::GridFrame;
use nalgebra::Matrix3;

fn localizer(map: &OccupancyGrid) -> GridLocalizer {
    GridLocalizer::new(map, GridSettings::default()).unwrap()
}

#[test]
fn maps_without_a_free_cell_are_refused() {
    let frame = GridFrame::new(20, 10, 0.1, Pose2::IDENTITY).unwrap();
    for value in [100, -1] {
        let map = OccupancyGrid::filled(frame, value);
        let error = GridLocalizer::new(&map, GridSettings::default()).unwrap_err();
        assert!(matches!(error, Error::NoFreeSpace { width: 20, height: 10 }));
        assert_eq!(
            error.to_string(),
            "map of 20 x 10 cells: expected at least one free cell, got none"
        );
    }
}

/// A single free cell is a map: the robot is there.
#[test]
fn one_free_cell_is_enough() {
    let frame = GridFrame::new(20, 10, 0.1, Pose2::IDENTITY).unwrap();
    let mut map = OccupancyGrid::filled(frame, 100);
    map.set(loc_maps::grid::Cell::new(7, 4), 0).unwrap();
    let localizer = localizer(&map);
    let at = localizer.mean().pose();
    assert!((at.x - 0.75).abs() < 0.11 && (at.y - 0.45).abs() < 0.11, "{at}");
}

#[test]
fn absurd_resolutions_are_refused_before_memory_runs_out() {
    let frame = GridFrame::new(4000, 4000, 0.05, Pose2::IDENTITY).unwrap();
    let map = OccupancyGrid::filled(frame, 0);
    let settings = GridSettings::default().cell(0.05).heading(0.01);
    let error = GridLocalizer::new(&map, settings).unwrap_err();
    assert!(matches!(error, Error::Core(CoreError::Length { .. })));
    assert_eq!(
        error.to_string(),
        "grid of poses: expected at most 2^26 poses (squares x headings): larger cells, or fewer \
         headings, got 10064000000 elements"
    );
    // The fine grid has the same limit.
    let fine = FineSettings::default().cell(1e-4);
    let error = GridLocalizer::new(&office(), GridSettings::default().fine(fine));
    assert!(matches!(error, Err(Error::Core(CoreError::Length { .. }))));
}

#[test]
fn settings_are_checked_one_by_one() {
    let map = office();
    let good = GridSettings::default();
    let bad = [
        (good.cell(0.0), "GridSettings.cell"),
        (good.heading(f64::NAN), "GridSettings.heading"),
        (good.heading(1e-9), "GridSettings.heading"),
        (good.beams(0), "GridSettings.beams"),
        (good.independent_beams(0.0), "GridSettings.independent_beams"),
        (good.kidnap_rate(1.5), "GridSettings.kidnap_rate"),
        (good.negligible(0.5), "GridSettings.negligible"),
        (good.update_turn(-1.0), "GridSettings.update_turn"),
        (good.robot(good.robot.laser_min_range(-1.0)), "RobotSettings.laser_min_range"),
        (good.fine(good.fine.reach(0.0)), "FineSettings.reach"),
        (good.fine(good.fine.turn(9.0)), "FineSettings.turn"),
    ];
    for (settings, name) in bad {
        let error = GridLocalizer::new(&map, settings).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{name}: expected ")), "{error}");
    }
}

#[test]
fn what_cannot_be_a_scan_leaves_the_belief() {
    let map = office();
    let mut robot = Robot::new(&map, 1);
    let mut localizer = localizer(&map);
    localizer.start_at(&pose_belief(robot.truth, [0.1, 0.1, 0.05])).unwrap();
    let before = localizer.belief();
    let good = robot.scan();
    let mut all_wrong = good.clone();
    all_wrong.ranges.fill(f64::NAN);
    let mut too_few = good.clone();
    too_few.ranges.truncate(10);
    for scan in [&all_wrong, &too_few] {
        assert!(localizer.update(robot.odometry, scan, Pose2::IDENTITY).is_err());
    }
    let nowhere = Pose2 { x: f64::NAN, ..Pose2::IDENTITY };
    assert!(localizer.update(nowhere, &good, Pose2::IDENTITY).is_err());
    assert!(localizer.update(robot.odometry, &good, nowhere).is_err());
    assert!(localizer.odometry(nowhere).is_err());
    assert_eq!(localizer.belief(), before);
}

/// Beams that saw nothing say nothing: the belief is moved along only.
#[test]
fn a_blind_scan_is_a_motion() {
    let map = office();
    let mut robot = Robot::new(&map, 1);
    let mut localizer = localizer(&map);
    localizer.start_at(&pose_belief(robot.truth, [0.1, 0.1, 0.05])).unwrap();
    let mut scan = robot.scan();
    scan.ranges.fill(f64::INFINITY);
    let update = localizer.update(robot.odometry, &scan, Pose2::IDENTITY).unwrap();
    assert_eq!(update, GridUpdate::Blind);
    assert!(localizer.belief().pose().distance(robot.truth) < 0.05);
}

/// A tenth of the beams NaN, a tenth without a return: the others do.
#[test]
fn broken_beams_are_left_out() {
    let map = office();
    let mut robot = Robot::new(&map, 4);
    let mut localizer = localizer(&map);
    let mut scan = robot.scan();
    for k in (0..scan.ranges.len() - 1).step_by(10) {
        scan.ranges[k] = f64::NAN;
        scan.ranges[k + 1] = f64::NEG_INFINITY;
    }
    localizer.start_at(&pose_belief(robot.truth, [0.2, 0.2, 0.1])).unwrap();
    localizer.update(robot.odometry, &scan, Pose2::IDENTITY).unwrap();
    assert!(localizer.belief().pose().distance(robot.truth) < 0.05);
}

/// Odometry that jumps leads nowhere on the map: the next scans find the robot anew.
#[test]
fn a_jump_of_the_odometry_is_survived() {
    let map = office();
    for jump in [4.0, 100.0, 1e300] {
        let mut robot = Robot::new(&map, 6);
        let mut localizer = localizer(&map);
        localizer.start_at(&pose_belief(robot.truth, [0.1, 0.1, 0.05])).unwrap();
        let scan = robot.scan();
        localizer.update(robot.odometry, &scan, Pose2::IDENTITY).unwrap();
        robot.odometry = robot.odometry * Pose2::new(jump, 0.0, 2.0);
        for _ in 0..2 {
            let scan = robot.scan();
            localizer.update(robot.odometry, &scan, Pose2::IDENTITY).unwrap();
            let sum: f64 = localizer.position_probabilities().iter().sum();
            assert!((sum - 1.0).abs() < 1e-9, "{jump}: {sum}");
            if jump < 1e6 {
                robot.drive();
            }
        }
        let estimate = localizer.belief();
        assert!(estimate.mean.iter().chain(&estimate.covariance).all(|v| v.is_finite()));
        assert!(estimate.pose().distance(robot.truth) < 0.4, "{jump}: {}", estimate.pose());
    }
}

#[test]
fn starts_in_a_wall_or_off_the_map_are_refused() {
    let map = office();
    let mut localizer = localizer(&map);
    let far = pose_belief(Pose2::new(500.0, 0.0, 0.0), [0.1, 0.1, 0.1]);
    let error = localizer.start_at(&far).unwrap_err();
    assert!(matches!(error, Error::NoRoom { .. }));
    assert_eq!(
        error.to_string(),
        "start of the robot: expected a free place within reach, got none"
    );
    let negative = Gaussian { mean: far.mean, covariance: -Matrix3::identity() };
    assert!(localizer.start_at(&negative).is_err());
    // Known exactly, or hardly at all: both are starts.
    let robot = Robot::new(&map, 3);
    localizer.start_at(&Gaussian::certain(robot.truth.to_vector())).unwrap();
    assert!(localizer.belief().pose().distance(robot.truth) < 0.03);
    localizer.start_at(&pose_belief(robot.truth, [3.0, 3.0, 2.0])).unwrap();
    assert!(localizer.belief().covariance.trace() > 0.1);
}
