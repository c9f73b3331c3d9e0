//! What cannot be right is refused by name, and changes nothing.

use super::{ROOM, all_around, map, scanner, seen, settings};
use loc_core::Pose2;
use loc_core::gaussian::pose_belief;
use loc_core::random::stream;
use loc_filters::Error;
use loc_filters::line_matching::{FieldOfView, LineEkf, LineMatchingSettings, Tracking};
use loc_maps::LineMap;
use loc_sensors::laser::LaserScan;
use nalgebra::Matrix2;

const START: Pose2 = Pose2 { x: 1.2, y: 1.4, theta: 0.2 };

fn ekf() -> LineEkf {
    LineEkf::new(map(ROOM), settings(), pose_belief(START, [0.05; 3])).unwrap()
}

fn scan() -> LaserScan {
    let scanner = scanner();
    scanner.scan(&map(ROOM), START, &mut stream(1, "scan"))
}

#[test]
fn maps_beliefs_and_settings_are_checked() {
    let belief = pose_belief(START, [0.05; 3]);
    let empty = LineMap::new([]).unwrap();
    let error = LineEkf::new(empty, settings(), belief).unwrap_err().to_string();
    assert_eq!(error, "line map: expected a map with at least one line, got 0 elements");
    let nowhere = pose_belief(Pose2 { x: f64::NAN, ..START }, [0.05; 3]);
    assert!(LineEkf::new(map(ROOM), settings(), nowhere).is_err());
    assert!(ekf().restart(nowhere).is_err());
    let change = |change: fn(&mut LineMatchingSettings)| {
        let mut settings = settings();
        change(&mut settings);
        let error = settings.check().unwrap_err().to_string();
        assert!(LineEkf::new(map(ROOM), settings, belief).is_err());
        error
    };
    for (error, message) in [
        (change(|s| s.map_sigma = -0.1), "LineMatchingSettings.map_sigma"),
        (change(|s| s.min_map_length = 0.0), "LineMatchingSettings.min_map_length"),
        (change(|s| s.robot.gate_probability = 0.0), "RobotSettings.gate_probability"),
        (change(|s| s.min_overlap = 1.5), "LineMatchingSettings.min_overlap"),
        (change(|s| s.slack = f64::NAN), "LineMatchingSettings.slack"),
        (change(|s| s.robot.path.along = f64::INFINITY), "PathNoise.along"),
        (change(|s| s.extractor.min_points = 2), "LineExtractor.min_points"),
        (change(|s| s.lost = s.lost.min_share(2.0)), "LostSettings.min_share"),
        (change(|s| s.systematic = s.systematic.drift(-1.0)), "SystematicErrors.drift"),
    ] {
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn bad_scans_lines_and_poses_change_nothing() {
    let mut ekf = ekf();
    let before = ekf.belief();
    let nan = LaserScan { ranges: vec![f64::NAN; 541], ..scan() };
    let error = ekf.scan(&nan, Pose2::IDENTITY).unwrap_err().to_string();
    assert!(error.contains("expected at least one that is not NaN"), "{error}");
    assert!(ekf.scan(&LaserScan { ranges: Vec::new(), ..scan() }, Pose2::IDENTITY).is_err());
    let mounting = Pose2 { x: f64::NAN, ..Pose2::IDENTITY };
    assert!(matches!(ekf.scan(&scan(), mounting), Err(Error::NotFinite { .. })));
    let odometry = Pose2 { theta: f64::INFINITY, ..START };
    assert!(matches!(ekf.odometry(odometry), Err(Error::NotFinite { .. })));

    let good = seen(START, [6.0, 0.5], [6.0, 3.5], [0.005, 0.002]);
    let bad = [
        loc_sensors::features::Line { r: f64::NAN, ..good },
        loc_sensors::features::Line { alpha: f64::INFINITY, ..good },
        loc_sensors::features::Line { start: [f64::NAN, 0.0].into(), ..good },
        loc_sensors::features::Line { covariance: Matrix2::new(1.0, 2.0, 2.0, 1.0), ..good },
        loc_sensors::features::Line { covariance: Matrix2::zeros(), ..good },
        loc_sensors::features::Line { covariance: Matrix2::from_element(f64::NAN), ..good },
    ];
    for line in bad {
        let error = ekf.lines(vec![good, line], all_around(), Pose2::IDENTITY).unwrap_err();
        assert!(error.to_string().contains("line of a scan"), "{error}");
    }
    for view in [
        FieldOfView { angle: 0.0, ..all_around() },
        FieldOfView { middle: f64::NAN, ..all_around() },
        FieldOfView { max_range: -1.0, ..all_around() },
    ] {
        assert!(ekf.lines(vec![good], view, Pose2::IDENTITY).is_err());
    }
    assert_eq!((ekf.belief(), ekf.tracking()), (before, Tracking::Sure));
}

/// A hall without walls in reach, a crowd all around: the filter waits.
#[test]
fn scans_without_lines_are_no_evidence() {
    let mut ekf = ekf();
    let before = ekf.belief();
    for ranges in [vec![f64::INFINITY; 541], (0..541).map(|k| 1.0 + f64::from(k % 3)).collect()] {
        for _ in 0..20 {
            let update = ekf.scan(&LaserScan { ranges: ranges.clone(), ..scan() }, Pose2::IDENTITY);
            let update = update.unwrap();
            assert_eq!((update.seen.len(), update.matched_share()), (0, None));
            assert_eq!(update.tracking, Tracking::Sure);
        }
    }
    let after = ekf.belief();
    assert_eq!(after.mean, before.mean);
    assert!(after.covariance.trace() >= before.covariance.trace());
}

/// Lines of almost no length in the map, walls that lie on each other, a robot on a wall.
#[test]
fn degenerate_maps_do_no_harm() {
    let odd = map(&format!("{ROOM}3,2,3.000000001,2\n0,0,6,0\n6,0,0,0\n1.2,1.4,1.2,1.41\n"));
    let mut ekf = LineEkf::new(odd, settings(), pose_belief(START, [0.05; 3])).unwrap();
    let scanner = scanner();
    let update = ekf.scan(&scan(), scanner.mounting).unwrap();
    assert!(update.after.mean.iter().all(|value| value.is_finite()));
    assert!(ekf.belief().pose().distance(START) < 0.01);
    let on_a_wall = pose_belief(Pose2::new(3.0, 0.0, 0.0), [0.01; 3]);
    ekf.restart(on_a_wall).unwrap();
    assert_eq!(ekf.scan(&scan(), Pose2::IDENTITY).unwrap().matched(), 0);
    assert_eq!(ekf.belief().mean, on_a_wall.mean);
}
