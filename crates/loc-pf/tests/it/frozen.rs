//! A scanner that repeats its last scan.

use crate::robot::{Robot, office};
use loc_core::Pose2;
use loc_core::gaussian::pose_belief;
use loc_core::random::stream;
use loc_filters::Localizer;
use loc_pf::mcl::MountedScan;
use loc_pf::{Mcl, MclSettings};
use loc_sensors::laser::LaserScan;

fn update(mcl: &mut Mcl, odometry: Pose2, scan: &LaserScan) {
    mcl.update(odometry, &[MountedScan { scan, mounting: Pose2::IDENTITY }]).unwrap();
}

/// Scans that are equal to the bit while the robot moves are no evidence: the pose follows the
/// odometry with a covariance that grows, and the scans count again once they are new.
#[test]
fn repeated_scans_do_not_hold_a_moving_robot_back() {
    for seed in 0..4 {
        let map = office(1);
        let mut robot = Robot::new(&map, Robot::laser(), seed);
        let mut mcl = Mcl::new(&map, MclSettings::default(), stream(seed, "mcl")).unwrap();
        mcl.start_at(&pose_belief(robot.truth, [0.1, 0.1, 0.05])).unwrap();
        for _ in 0..5 {
            robot.drive();
            let scan = robot.scan();
            update(&mut mcl, robot.odometry, &scan);
        }
        let (frozen, before) = (robot.scan(), mcl.belief().covariance);
        update(&mut mcl, robot.odometry, &frozen);
        assert!(mcl.notes().iter().all(|note| !note.contains("equal to the one before")));
        for _ in 0..15 {
            robot.drive();
            update(&mut mcl, robot.odometry, &frozen);
        }
        let after = mcl.belief().covariance;
        let (error, _) = robot.error(mcl.pose());
        let sigma = (after.m11 + after.m22).sqrt();
        assert!(error < 1.0 && error < 4.0 * sigma, "{seed}: {error} m, sigma {sigma} m");
        assert!(after.m11 + after.m22 > 2.0 * (before.m11 + before.m22), "{seed}: {after}");
        let notes = mcl.notes().join("\n");
        assert!(
            notes.contains("scans were equal to the one before while the robot moved"),
            "{notes}"
        );
        for _ in 0..5 {
            robot.drive();
            let scan = robot.scan();
            update(&mut mcl, robot.odometry, &scan);
        }
        assert!(robot.error(mcl.pose()).0 < 0.15, "{seed}: {}", robot.error(mcl.pose()).0);
    }
}
