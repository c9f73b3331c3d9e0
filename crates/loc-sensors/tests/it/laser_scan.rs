use approx::assert_relative_eq;
use loc_core::{Pose2, Twist2};
use loc_sensors::Error;
use loc_sensors::laser::LaserScan;
use std::f64::consts::FRAC_PI_2;

const INF: f64 = f64::INFINITY;

/// Beams at -90, -45, 0, 45 and 90 degrees.
fn scan(ranges: [f64; 5]) -> LaserScan {
    LaserScan {
        angle_min: -FRAC_PI_2,
        angle_max: FRAC_PI_2,
        angle_increment: FRAC_PI_2 / 2.0,
        time_increment: 0.01,
        scan_time: 0.1,
        range_min: 0.5,
        range_max: 10.0,
        ranges: ranges.to_vec(),
        intensities: Vec::new(),
    }
}

#[test]
fn only_measurements_are_beams() {
    let scan = scan([0.5, f64::NAN, 10.0, INF, -INF]);
    scan.check().unwrap();
    let beams: Vec<_> = scan.beams().map(|beam| (beam.index, beam.range)).collect();
    assert_eq!(beams, [(0, 0.5), (2, 10.0)], "both limits are measurements");
    assert!(!scan.is_valid(0.49) && !scan.is_valid(10.01) && !scan.is_valid(f64::NAN));
}

#[test]
fn points_by_hand() {
    let scan = scan([1.0, INF, 2.0, INF, 3.0]);
    let mounting = Pose2::new(0.5, 0.0, FRAC_PI_2);
    let points: Vec<_> = scan.points(mounting).collect();
    for (point, [x, y]) in points.iter().zip([[1.5, 0.0], [0.5, 2.0], [-2.5, 0.0]]) {
        assert_relative_eq!(point.x, x, epsilon = 1e-12);
        assert_relative_eq!(point.y, y, epsilon = 1e-12);
    }
    assert_eq!(points.len(), 3);
    let own: Vec<_> = scan.points(Pose2::IDENTITY).collect();
    for (point, beam) in own.iter().zip(scan.beams()) {
        assert_relative_eq!(*point, beam.point(), epsilon = 1e-12);
    }
}

/// A robot at 2 m/s forward is 4 cm ahead after the two steps of 0.01 s to the middle beam.
#[test]
fn points_of_a_moving_robot_by_hand() {
    let scan = scan([INF, INF, 1.0, INF, INF]);
    let twist = Twist2::forward(2.0, 0.0);
    let point = scan.points_of_moving(Pose2::new(0.2, 0.0, 0.0), twist).next().unwrap();
    assert_relative_eq!(point.x, 1.24, epsilon = 1e-12);
    assert_relative_eq!(point.y, 0.0, epsilon = 1e-12);
}

#[test]
fn thinning_spreads_over_what_is_valid() {
    let mut long = scan([1.0; 5]);
    long.angle_increment = 0.01;
    long.angle_max = long.angle_min + 0.01 * 99.0;
    long.ranges = (0..100).map(|k| if k < 60 { INF } else { 1.0 }).collect();
    let kept = |count| long.thinned(count).iter().map(|beam| beam.index).collect::<Vec<_>>();
    assert_eq!(kept(5), [60, 70, 80, 89, 99]);
    assert_eq!(kept(2), [60, 99]);
    assert_eq!(kept(1), [80]);
    assert_eq!(kept(0), Vec::<usize>::new());
    assert_eq!(kept(40), (60..100).collect::<Vec<_>>());
    assert_eq!(kept(1000).len(), 40);
    assert_eq!(scan([INF; 5]).thinned(3), []);
}

#[test]
fn bad_scans_are_refused() {
    let good = scan([1.0; 5]);
    let without_beams = LaserScan { ranges: Vec::new(), ..good.clone() };
    let too_many = LaserScan { ranges: vec![1.0; 7], ..good.clone() };
    let half_bright = LaserScan { intensities: vec![1.0; 4], ..good.clone() };
    for bad in [without_beams, too_many, half_bright] {
        assert!(matches!(bad.check(), Err(Error::Length { .. })), "{bad:?}");
    }
    for bad in [
        LaserScan { angle_increment: 0.0, ..good.clone() },
        LaserScan { angle_increment: f64::NAN, ..good.clone() },
        LaserScan { angle_min: -INF, ..good.clone() },
        LaserScan { time_increment: -1.0, ..good.clone() },
        LaserScan { range_min: 10.0, ..good.clone() },
        LaserScan { range_max: INF, ..good.clone() },
        scan([f64::NAN; 5]),
    ] {
        assert!(matches!(bad.check(), Err(Error::OutOfRange { .. })), "{bad:?}");
    }
    let error = scan([f64::NAN; 5]).check().unwrap_err().to_string();
    assert_eq!(error, "ranges of a scan [m]: expected at least one that is not NaN, got NaN");
}

/// Real drivers set angle_max one step off, hang scanners upside down, and report empty halls.
#[test]
fn what_devices_really_send_is_let_through() {
    let good = scan([1.0; 5]);
    LaserScan { angle_max: good.angle_max + good.angle_increment, ..good.clone() }.check().unwrap();
    let upside_down = LaserScan {
        angle_min: good.angle_max,
        angle_max: good.angle_min,
        angle_increment: -good.angle_increment,
        ..good.clone()
    };
    upside_down.check().unwrap();
    assert_relative_eq!(upside_down.angle(4), good.angle_min);
    scan([INF; 5]).check().unwrap();
    LaserScan { intensities: vec![0.0; 5], ..good }.check().unwrap();
}
