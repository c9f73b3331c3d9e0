//! Input that is wrong, or strange: a typed error or a defined behaviour, never a panic or a NaN.

use crate::robot::{Robot, office};
use loc_core::gaussian::pose_belief;
use loc_core::random::stream;
use loc_core::{Gaussian, Pose2};
use loc_maps::grid::{GridFrame, OccupancyGrid};
use loc_pf::adaptive::KldSettings;
use loc_pf::mcl::{MountedScan, Update};
use loc_pf::{Error, Mcl, MclSettings, Particles};
use loc_sensors::laser::LaserScan;

fn update(mcl: &mut Mcl, odometry: Pose2, scan: &LaserScan) -> loc_pf::Result<Update> {
    mcl.update(odometry, &[MountedScan { scan, mounting: Pose2::IDENTITY }])
}

fn start(seed: u64) -> (Robot, Mcl) {
    let map = office(1);
    let robot = Robot::new(&map, Robot::laser(), seed);
    let mut mcl = Mcl::new(&map, MclSettings::default(), stream(seed, "mcl")).unwrap();
    mcl.start_at(&pose_belief(robot.truth, [0.2, 0.2, 0.1])).unwrap();
    (robot, mcl)
}

fn is_sound(mcl: &Mcl) -> bool {
    let covariance = mcl.belief().covariance;
    mcl.pose().is_finite()
        && covariance.iter().all(|value| value.is_finite())
        && mcl.particles().check().is_ok()
        && (mcl.particles().weights().sum::<f64>() - 1.0).abs() < 1e-6
}

#[test]
fn a_scan_of_nan_only_is_refused_and_changes_nothing() {
    let (mut robot, mut mcl) = start(1);
    let mut scan = robot.scan();
    scan.ranges.fill(f64::NAN);
    let before = mcl.state();
    let error = update(&mut mcl, robot.odometry, &scan).unwrap_err().to_string();
    assert!(error.contains("at least one that is not NaN"), "{error}");
    assert_eq!(before, mcl.state());
}

#[test]
fn a_scan_without_returns_only_moves_the_particles() {
    let (mut robot, mut mcl) = start(2);
    update(&mut mcl, robot.odometry, &robot.scan()).unwrap();
    let before = mcl.belief().covariance[(0, 0)];
    for _ in 0..4 {
        robot.drive();
        let mut scan = robot.scan();
        scan.ranges.fill(f64::INFINITY);
        update(&mut mcl, robot.odometry, &scan).unwrap();
    }
    assert!(is_sound(&mcl) && mcl.belief().covariance[(0, 0)] > before);
    assert!(robot.error(mcl.pose()).0 < 0.5);
}

#[test]
fn the_number_of_beams_may_change() {
    let (mut robot, mut mcl) = start(3);
    for k in 0..8 {
        robot.drive();
        let mut scan = robot.scan();
        if k % 2 == 1 {
            scan.ranges.truncate(31);
            scan.angle_max = scan.angle_min + 30.0 * scan.angle_increment;
        }
        update(&mut mcl, robot.odometry, &scan).unwrap();
        assert!(is_sound(&mcl));
    }
    assert!(robot.error(mcl.pose()).0 < 0.3);
}

#[test]
fn a_start_off_the_map_is_refused_and_one_in_a_wall_is_not() {
    let (robot, mut mcl) = start(4);
    let before = mcl.state();
    let off = pose_belief(Pose2::new(-500.0, 3.0, 0.0), [0.1, 0.1, 0.1]);
    assert!(matches!(mcl.start_at(&off), Err(Error::OffMap { .. })));
    let nan = Gaussian { mean: [f64::NAN, 0.0, 0.0].into(), ..off };
    assert!(mcl.start_at(&nan).is_err());
    let negative = Gaussian { mean: robot.truth.to_vector(), covariance: -off.covariance };
    assert!(mcl.start_at(&negative).is_err());
    assert_eq!(before, mcl.state());
    mcl.start_at(&pose_belief(Pose2::new(0.02, 0.02, 0.0), [0.1, 0.1, 0.1])).unwrap();
    let mut robot = robot;
    update(&mut mcl, robot.odometry, &robot.scan()).unwrap();
    assert!(is_sound(&mcl));
}

#[test]
fn a_map_without_free_cells_is_refused() {
    let frame = GridFrame::new(20, 10, 0.05, Pose2::IDENTITY).unwrap();
    for value in [100, -1] {
        let map = OccupancyGrid::filled(frame, value);
        let error = Mcl::new(&map, MclSettings::default(), stream(1, "mcl")).unwrap_err();
        assert_eq!(error.to_string(), "map of 20 x 10 cells: expected free cells, got none");
    }
}

#[test]
fn a_jump_of_the_odometry_is_survived() {
    let (mut robot, mut mcl) = start(5);
    for _ in 0..3 {
        robot.drive();
        update(&mut mcl, robot.odometry, &robot.scan()).unwrap();
    }
    robot.odometry.x += 100.0;
    for _ in 0..6 {
        update(&mut mcl, robot.odometry, &robot.scan()).unwrap();
        assert!(is_sound(&mcl));
        robot.drive();
    }
    assert!(robot.error(mcl.pose()).0 < 0.5, "{}", robot.error(mcl.pose()).0);
}

#[test]
fn odometry_that_is_no_number_is_refused_and_changes_nothing() {
    let (mut robot, mut mcl) = start(6);
    update(&mut mcl, robot.odometry, &robot.scan()).unwrap();
    let before = mcl.state();
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(update(&mut mcl, Pose2::new(bad, 0.0, 0.0), &robot.scan()).is_err());
        assert!(mcl.odometry(Pose2 { x: 0.0, y: 0.0, theta: bad }).is_err());
    }
    assert_eq!(before, mcl.state());
}

#[test]
fn weights_that_all_underflow_become_equal() {
    let mut cloud = Particles::from_poses([Pose2::IDENTITY; 5]);
    cloud.log_weights_mut().fill(f64::NEG_INFINITY);
    assert_eq!(cloud.normalize(), f64::NEG_INFINITY);
    assert!(cloud.weights().all(|weight| (weight - 0.2).abs() < 1e-12));
    cloud.log_weights_mut().copy_from_slice(&[-1e5, -1e5 - 1.0, -1e6, -1e7, -1e300]);
    cloud.normalize();
    assert!((cloud.weight(0) - 1.0 / (1.0 + (-1_f64).exp())).abs() < 1e-9);
}

#[test]
fn settings_out_of_range_are_named() {
    let map = office(1);
    let refused =
        |settings: MclSettings| Mcl::new(&map, settings, stream(1, "mcl")).unwrap_err().to_string();
    let kld = |min_particles, max_particles| {
        MclSettings::default().particles(
            KldSettings::default().min_particles(min_particles).max_particles(max_particles),
        )
    };
    assert!(refused(kld(0, 10)).contains("min_particles"));
    assert!(refused(kld(11, 10)).contains("max_particles"));
    assert!(refused(MclSettings::default().beams(0)).contains("beams"));
    let settings = MclSettings::default().independent_beams(f64::NAN);
    assert!(refused(settings).contains("independent_beams"));
    let settings = MclSettings::default().update_distance(-1.0);
    assert!(refused(settings).contains("update_distance"));
}

#[test]
fn a_saved_state_may_be_anything() {
    let (_, mut mcl) = start(7);
    let mut state = serde_json::to_value(mcl.state()).unwrap();
    state["particles"]["x"][0] = serde_json::Value::from("far");
    assert!(serde_json::from_value::<loc_pf::mcl::MclState>(state.clone()).is_err());
    state["particles"]["x"] = serde_json::json!([1.0]);
    let state = serde_json::from_value(state).unwrap();
    assert!(mcl.restore(state).is_err());
}
