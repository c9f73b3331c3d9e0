//! Whole drives: honest covariances, what the odometry gets wrong, and robots that get lost.

use super::{ROOM, all_around, map, scanner, seen, settings};
use loc_core::Pose2;
use loc_core::gaussian::pose_belief;
use loc_core::random::stream;
use loc_core::stats::{chi_square_band, nees};
use loc_filters::line_matching::{
    LineEkf, LineMatchingSettings, LineUpdate, SystematicErrors, Tracking,
};

/// A drive through a room from a rough start, with scans; the deviations after each correction.
fn drive(seed: u64, settings: LineMatchingSettings) -> Vec<(LineUpdate, Pose2)> {
    let (map, scanner) = (map(ROOM), scanner());
    let mut rng = stream(seed, "drive");
    let mut truth = Pose2::new(1.2, 1.4, 0.2);
    let mut start = pose_belief(truth, [0.1, 0.1, 0.05]);
    start.mean = start.sample(&mut rng);
    let mut ekf = LineEkf::new(map.clone(), settings, start).unwrap();
    let mut odometry = Pose2::new(7.0, -3.0, 1.0);
    ekf.odometry(odometry).unwrap();
    let mut updates = Vec::new();
    for k in 0..12 {
        let step = Pose2::new(0.15, 0.0, if k % 6 < 3 { 0.2 } else { -0.15 });
        truth = truth * step;
        let noise = pose_belief(Pose2::IDENTITY, [0.02, 0.01, 0.02]).sample(&mut rng);
        odometry = odometry * step * Pose2::from_vector(&noise);
        ekf.odometry(odometry).unwrap();
        let scan = scanner.scan(&map, truth, &mut rng);
        updates.push((ekf.scan(&scan, scanner.mounting).unwrap(), truth));
    }
    updates
}

/// Over 50 seeds the normalised errors are chi-square distributed with 3 degrees of freedom.
#[test]
fn the_covariance_is_honest() {
    let (mut sum, mut count, mut worst) = (0.0, 0, 0.0_f64);
    for seed in 0..50 {
        for (update, truth) in drive(seed, settings()) {
            assert_eq!(update.tracking, Tracking::Sure, "seed {seed}");
            let deviation = update.after.pose_deviation(truth);
            sum += nees(&deviation, &update.after.covariance).unwrap();
            worst = worst.max(update.after.pose().distance(truth));
            count += 1;
        }
    }
    let band = chi_square_band(3, count, 0.999).unwrap();
    let mean = sum / f64::from(u32::try_from(count).unwrap());
    assert!(band.contains(&mean), "mean NEES {mean} outside {band:?}");
    assert!(worst < 0.02, "{worst} m");
}

/// Wheels that are not of one size: the filter finds out what its odometry gets wrong.
#[test]
fn systematic_errors_of_the_odometry_are_found() {
    let (map, scanner) = (map(ROOM), scanner());
    let mut rng = stream(4, "drift");
    let (mut truth, mut odometry) = (Pose2::new(1.2, 1.4, 0.2), Pose2::IDENTITY);
    // Apart from that, it errs little.
    let mut smooth = settings();
    (smooth.robot.path.drift, smooth.robot.path.turn) = (0.01, 0.01);
    let mut ekf = LineEkf::new(map.clone(), smooth, pose_belief(truth, [0.02; 3])).unwrap();
    ekf.odometry(odometry).unwrap();
    for k in 0..120 {
        let step = Pose2::new(0.2, 0.0, if k % 24 < 12 { 0.26 } else { -0.26 });
        truth = truth * step;
        // The heading drifts by 3 degrees per metre to the right, ways are 4 % too long.
        odometry =
            odometry * Pose2::new(0.2 / 0.96, 0.0, step.theta - 3_f64.to_radians() * 0.2 / 0.96);
        ekf.odometry(odometry).unwrap();
        ekf.scan(&scanner.scan(&map, truth, &mut rng), scanner.mounting).unwrap();
    }
    let found = ekf.systematic();
    let sigma = |k: usize| found.covariance[(k, k)].sqrt();
    assert!((found.mean.x.to_degrees() - 3.0).abs() < 0.4, "{found:?}");
    assert!((found.mean.y + 0.04).abs() < 0.012, "{found:?}");
    assert!((found.mean.x - 3_f64.to_radians()).abs() < 3.0 * sigma(0), "{found:?}");
    assert!((found.mean.y + 0.04).abs() < 3.0 * sigma(1), "{found:?}");
    // One without them in its settings does not estimate them.
    let none = SystematicErrors::default().drift(0.0).scale(0.0).wander(0.0);
    let reported = settings().systematic(none);
    let mut ekf = LineEkf::new(map, reported, pose_belief(truth, [0.02; 3])).unwrap();
    ekf.odometry(Pose2::IDENTITY).unwrap();
    ekf.odometry(Pose2::new(0.3, 0.0, 0.2)).unwrap();
    ekf.scan(&scanner.scan(ekf.map().as_ref(), truth, &mut rng), scanner.mounting).unwrap();
    assert_eq!(ekf.systematic().mean.norm() + ekf.systematic().covariance.norm(), 0.0);
}

/// Two walls along a corridor say nothing about the place along it.
#[test]
fn in_a_corridor_the_covariance_stays_large_along_it() {
    let corridor = map("0,0,100,0\n0,2,100,2\n");
    let mut ekf = LineEkf::new(
        corridor,
        settings(),
        pose_belief(Pose2::new(50.0, 1.0, 0.0), [0.5, 0.1, 0.05]),
    )
    .unwrap();
    let mut truth = Pose2::new(50.3, 0.95, 0.02);
    let mut odometry = Pose2::IDENTITY;
    ekf.odometry(odometry).unwrap();
    for _ in 0..30 {
        let step = Pose2::new(0.3, 0.0, 0.0);
        (truth, odometry) = (truth * step, odometry * step);
        ekf.odometry(odometry).unwrap();
        let walls = [([0.0, 0.0], [100.0, 0.0]), ([0.0, 2.0], [100.0, 2.0])];
        let lines = walls.map(|(a, b)| seen(truth, a, b, [0.005, 0.002])).to_vec();
        assert_eq!(ekf.lines(lines, all_around(), Pose2::IDENTITY).unwrap().matched(), 2);
    }
    let belief = ekf.belief();
    let sigma = |k: usize| belief.covariance[(k, k)].sqrt();
    assert!(sigma(0) > 0.5 && sigma(1) < 0.01 && sigma(2) < 0.005, "{belief:?}");
    assert!((belief.mean.y - truth.y).abs() < 0.02);
}

/// Carried away, the robot says so after some scans; found again, it goes on.
#[test]
fn a_lost_robot_says_so_and_can_be_restarted() {
    let (map, scanner) = (map(ROOM), scanner());
    let mut rng = stream(8, "lost");
    let start = Pose2::new(1.2, 1.4, 0.2);
    let mut ekf = LineEkf::new(map.clone(), settings(), pose_belief(start, [0.02; 3])).unwrap();
    ekf.odometry(Pose2::IDENTITY).unwrap();
    let elsewhere = Pose2::new(4.6, 2.6, -2.0);
    let patience = settings().lost.scans;
    for k in 1..=30 {
        let before = ekf.belief();
        let scan = scanner.scan(&map, elsewhere, &mut rng);
        let update = ekf.scan(&scan, scanner.mounting).unwrap();
        let expected = if k < patience { Tracking::Doubtful(k) } else { Tracking::Lost(k) };
        assert_eq!((update.tracking, ekf.tracking()), (expected, expected));
        // Chance pairs change nothing.
        assert_eq!((update.matched(), ekf.belief()), (0, before));
    }
    ekf.restart(pose_belief(Pose2::new(4.5, 2.7, -2.1), [0.2, 0.2, 0.2])).unwrap();
    let update = ekf.scan(&scanner.scan(&map, elsewhere, &mut rng), scanner.mounting).unwrap();
    assert_eq!(update.tracking, Tracking::Sure);
    assert!(ekf.belief().pose().distance(elsewhere) < 0.01);
}

/// Wheels that spin: odometry says 1 m and a turn that never were, and one scan puts it right.
#[test]
fn one_scan_mends_a_failure_of_the_odometry() {
    let (map, scanner) = (map(ROOM), scanner());
    let truth = Pose2::new(1.2, 1.4, 0.2);
    let scan = scanner.scan(&map, truth, &mut stream(2, "slip"));
    let after_slip = |fault_probability: f64| {
        let mut settings = settings();
        settings.robot.path.fault_probability = fault_probability;
        let mut ekf = LineEkf::new(map.clone(), settings, pose_belief(truth, [0.01; 3])).unwrap();
        ekf.odometry(Pose2::IDENTITY).unwrap();
        ekf.odometry(Pose2::new(0.9, 0.2, 0.35)).unwrap();
        let update = ekf.scan(&scan, scanner.mounting).unwrap();
        (update.tracking, ekf.belief().pose().distance(truth))
    };
    let (tracking, error) = after_slip(0.1);
    assert!(tracking == Tracking::Sure && error < 0.01, "{tracking:?} {error}");
    assert_eq!(after_slip(0.0).0, Tracking::Doubtful(1));
}
