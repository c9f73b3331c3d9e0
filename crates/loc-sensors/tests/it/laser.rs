use approx::assert_relative_eq;
use loc_core::random::stream;
use loc_core::stats::RunningMoments;
use loc_core::{Pose2, Twist2};
use loc_sensors::Error;
use loc_sensors::laser::{LaserFaults, LaserNoise, LaserScan, LaserScanner, LaserSpec};
use loc_sensors::world::{Glazed, Pane, RangeWorld, Room, Surface};
use nalgebra::Point2;
use std::f64::consts::{FRAC_PI_2, PI};

fn perfect() -> LaserScanner {
    let spec = LaserSpec { noise: LaserNoise::NONE, ..LaserSpec::hokuyo_ust_10lx() };
    LaserScanner::new(spec).unwrap()
}

fn room() -> Room {
    Room::new([-3.0, -2.0], [3.0, 2.0]).unwrap()
}

fn look(scanner: &LaserScanner, world: &impl RangeWorld, pose: Pose2) -> LaserScan {
    let scan = scanner.scan(world, pose, &mut stream(1, "laser"));
    scan.check().unwrap();
    scan
}

/// The range of the beam straight ahead.
fn ahead(world: &impl RangeWorld, pose: Pose2) -> f64 {
    look(&perfect(), world, pose).ranges[540]
}

#[test]
fn presets_have_the_figures_of_their_data_sheets() {
    let deg = f64::to_radians;
    for (spec, beams, step, rate, reach) in [
        (LaserSpec::hokuyo_ust_10lx(), 1081, 0.25, 40.0, 10.0),
        (LaserSpec::sick_lms100(), 1081, 0.25, 25.0, 18.0),
        (LaserSpec::sick_lms100_50_hz(), 541, 0.5, 50.0, 18.0),
    ] {
        spec.check().unwrap();
        assert_eq!((spec.beams, spec.rate, spec.range_max), (beams, rate, reach));
        assert_relative_eq!(spec.angle_increment, deg(step));
        assert_relative_eq!(spec.angle_max(), deg(135.0), epsilon = 1e-12);
        assert_relative_eq!(spec.time_increment() * 360.0 / step * rate, 1.0, epsilon = 1e-12);
    }
}

#[test]
fn mounting_and_pose_by_hand() {
    let scanner = LaserScanner { mounting: Pose2::new(0.5, 0.0, FRAC_PI_2), ..perfect() };
    let scan = look(&scanner, &room(), Pose2::new(1.0, 1.0, FRAC_PI_2));
    // The scanner is at (1, 1.5) and looks west.
    assert_relative_eq!(scan.ranges[540], 4.0, epsilon = 1e-12);
    assert_relative_eq!(scan.ranges[540 - 360], 0.5, epsilon = 1e-9);
    // Every point lies on the wall of the room.
    let laser = Pose2::new(1.0, 1.5, PI);
    for point in scan.points(laser) {
        let to_wall = (3.0 - point.x.abs()).abs().min((2.0 - point.y.abs()).abs());
        assert!(to_wall < 1e-9, "{point}");
    }
}

#[test]
fn out_of_range_is_infinite() {
    let hall = Room::new([-50.0, -0.05], [50.0, 5.0]).unwrap();
    let scan = look(&perfect(), &hall, Pose2::IDENTITY);
    assert_eq!(scan.ranges[540], f64::INFINITY);
    assert_eq!(scan.ranges[180], f64::NEG_INFINITY, "5 cm to the right");
    assert_relative_eq!(scan.ranges[900], 5.0, epsilon = 1e-9);
}

#[test]
fn noise_has_its_variance() {
    let noise = LaserNoise { sigma: 0.02, sigma_per_m: 0.005 };
    let scanner = LaserScanner::new(LaserSpec { noise, ..LaserSpec::sick_lms100() }).unwrap();
    let mut rng = stream(2, "laser");
    let (mut ahead, mut side) = (RunningMoments::new(), RunningMoments::new());
    for _ in 0..5000 {
        let scan = scanner.scan(&room(), Pose2::IDENTITY, &mut rng);
        ahead.push(scan.ranges[540]).unwrap();
        side.push(scan.ranges[900]).unwrap();
    }
    // 5000 draws know a standard deviation to 1 %.
    assert_relative_eq!(ahead.mean().unwrap(), 3.0, epsilon = 0.002);
    assert_relative_eq!(ahead.standard_deviation().unwrap(), 0.035, max_relative = 0.03);
    assert_relative_eq!(side.mean().unwrap(), 2.0, epsilon = 0.002);
    assert_relative_eq!(side.standard_deviation().unwrap(), 0.03, max_relative = 0.03);
}

#[test]
fn faults_come_at_their_rates() {
    let faults = LaserFaults { dropout: 0.1, erroneous: 0.05, short: 0.2 };
    let scanner = LaserScanner { faults, ..perfect() };
    let (mut rng, rounds) = (stream(3, "laser"), 100);
    let [mut lost, mut failed, mut short] = [0, 0, 0];
    for _ in 0..rounds {
        let scan = scanner.scan(&room(), Pose2::IDENTITY, &mut rng);
        for (range, truth) in
            scan.ranges.iter().zip(look(&perfect(), &room(), Pose2::IDENTITY).ranges)
        {
            lost += u32::from(*range == f64::INFINITY);
            failed += u32::from(range.is_nan());
            short += u32::from(*range < truth - 1e-9);
        }
    }
    let share = |count: u32| f64::from(count) / (1081.0 * f64::from(rounds));
    assert_relative_eq!(share(lost), 0.1, epsilon = 0.005);
    assert_relative_eq!(share(failed), 0.05, epsilon = 0.005);
    assert_relative_eq!(share(short), 0.2, epsilon = 0.005);
}

#[test]
fn one_seed_one_scan() {
    let scanner = LaserScanner::new(LaserSpec::hokuyo_ust_10lx()).unwrap();
    let scan = |seed| scanner.scan(&room(), Pose2::IDENTITY, &mut stream(seed, "laser"));
    assert_eq!(scan(1), scan(1));
    assert_ne!(scan(1), scan(2));
}

#[test]
fn glass_lets_beams_pass() {
    let pane = |pass| Pane { from: [1.0, -1.0], to: [1.0, 1.0], surface: Surface::Glass { pass } };
    let behind = |pass| ahead(&Glazed::new(room(), [pane(pass)]).unwrap(), Pose2::IDENTITY);
    assert_relative_eq!(behind(0.0), 1.0);
    assert_relative_eq!(behind(1.0), 3.0);
    let world = Glazed::new(room(), [pane(0.7)]).unwrap();
    let mut rng = stream(4, "laser");
    let scans = (0..2000).map(|_| perfect().scan(&world, Pose2::IDENTITY, &mut rng).ranges[540]);
    let passed = scans.filter(|range| *range > 2.0).count();
    assert_relative_eq!(passed as f64 / 2000.0, 0.7, epsilon = 0.03);
    // Two panes one behind the other, and a wall before both.
    let second = Pane { from: [2.0, -1.0], to: [2.0, 1.0], surface: Surface::Glass { pass: 0.0 } };
    assert_relative_eq!(
        ahead(&Glazed::new(room(), [second, pane(1.0)]).unwrap(), Pose2::IDENTITY),
        2.0
    );
    let pillar = room().with_pillar([0.6, 0.0], 0.1).unwrap();
    let hidden = Glazed::new(&pillar, [pane(0.0)]).unwrap();
    assert_relative_eq!(ahead(&hidden, Pose2::IDENTITY), 0.5, epsilon = 1e-12);
}

#[test]
fn mirrors_turn_beams() {
    // At 45 degrees, 1 m ahead: the beam goes on to the wall on the left.
    let tilted = Pane { from: [0.5, -0.5], to: [1.5, 0.5], surface: Surface::Mirror };
    let world = Glazed::new(room(), [tilted]).unwrap();
    assert_relative_eq!(ahead(&world, Pose2::IDENTITY), 1.0 + 2.0, epsilon = 1e-9);
    // Straight ahead: back past the robot to the wall behind it.
    let upright = Pane { from: [1.0, -1.0], to: [1.0, 1.0], surface: Surface::Mirror };
    let world = Glazed::new(room(), [upright]).unwrap();
    assert_relative_eq!(ahead(&world, Pose2::new(-1.0, 0.0, 0.0)), 2.0 + 4.0, epsilon = 1e-9);
    // Between two mirrors no beam returns.
    let behind = Pane { from: [-1.0, -1.0], to: [-1.0, 1.0], surface: Surface::Mirror };
    let world = Glazed::new(room(), [upright, behind]).unwrap();
    assert_eq!(ahead(&world, Pose2::IDENTITY), f64::INFINITY);
}

#[test]
fn motion_during_the_sweep_by_hand() {
    let scanner = perfect();
    let twist = Twist2::forward(2.0, 0.0);
    let pose = Pose2::new(-1.0, 0.0, 0.0);
    let scan = scanner.scan_moving(&room(), pose, twist, &mut stream(1, "laser"));
    // Beam 540 comes 540/1440 of 25 ms after beam 0: 18.75 mm farther on.
    assert_relative_eq!(scan.ranges[540], 4.0 - 0.018_75, epsilon = 1e-9);
    // Undone, all points lie on the walls again; left in, they do not.
    let off = |point: Point2<f64>| {
        let there = pose.transform(&point);
        (3.0 - there.x.abs()).abs().min((2.0 - there.y.abs()).abs())
    };
    let turning = Twist2::forward(1.0, 2.0);
    let scan = scanner.scan_moving(&room(), pose, turning, &mut stream(1, "laser"));
    let undone = scan.points_of_moving(Pose2::IDENTITY, turning).map(off).fold(0.0, f64::max);
    assert!(undone < 1e-9, "{undone}");
    assert!(scan.points(Pose2::IDENTITY).map(off).fold(0.0, f64::max) > 0.01);
    // Standing still it is the same scan, but for rounding.
    let still = scanner.scan_moving(&room(), pose, Twist2::ZERO, &mut stream(1, "laser"));
    for (a, b) in still.ranges.iter().zip(&look(&scanner, &room(), pose).ranges) {
        assert_relative_eq!(a, b, epsilon = 1e-9);
    }
}

#[test]
fn bad_settings_are_refused() {
    let spec = LaserSpec::hokuyo_ust_10lx();
    for bad in [
        LaserSpec { beams: 0, ..spec },
        LaserSpec { beams: 2000, ..spec },
        LaserSpec { beams: usize::MAX, ..spec },
        LaserSpec { angle_increment: 0.0, ..spec },
        LaserSpec { rate: 0.0, ..spec },
        LaserSpec { range_min: 10.0, ..spec },
        LaserSpec { noise: LaserNoise { sigma: f64::NAN, sigma_per_m: 0.0 }, ..spec },
    ] {
        assert!(LaserScanner::new(bad).is_err(), "{bad:?}");
    }
    let faults = LaserFaults { dropout: 0.6, erroneous: 0.6, short: 0.0 };
    assert!(LaserScanner { faults, ..perfect() }.check().is_err());
    let nowhere = Pose2 { x: f64::NAN, ..Pose2::IDENTITY };
    assert!(LaserScanner { mounting: nowhere, ..perfect() }.check().is_err());
}

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
