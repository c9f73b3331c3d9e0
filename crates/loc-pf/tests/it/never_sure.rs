//! Places and faults at which a filter has no right to be sure.

use crate::robot::{Robot, office};
use loc_core::gaussian::pose_belief;
use loc_core::random::stream;
use loc_core::{Pose2, angle};
use loc_filters::Localizer;
use loc_maps::OccupancyGrid;
use loc_maps::grid::{Cell, GridFrame};
use loc_pf::confidence::ScanRater;
use loc_pf::mcl::{MountedScan, Update};
use loc_pf::{Mcl, MclSettings};
use loc_sensors::laser::{Beam, LaserScan, LaserScanner, LaserSpec};

fn update(mcl: &mut Mcl, odometry: Pose2, scan: &LaserScan) -> Update {
    mcl.update(odometry, &[MountedScan { scan, mounting: Pose2::IDENTITY }]).unwrap()
}

/// Walls around a hall of some size \[m\], in cells of 5 cm.
fn hall(width: f64, height: f64) -> OccupancyGrid {
    let [columns, rows] = [width, height].map(|side| (side / 0.05) as usize);
    let frame = GridFrame::new(columns, rows, 0.05, Pose2::IDENTITY).unwrap();
    let mut grid = OccupancyGrid::filled(frame, 0);
    fill(&mut grid, 0..columns, 0..2, 100);
    fill(&mut grid, 0..columns, rows - 2..rows, 100);
    fill(&mut grid, 0..2, 0..rows, 100);
    fill(&mut grid, columns - 2..columns, 0..rows, 100);
    grid
}

fn fill(
    grid: &mut OccupancyGrid,
    columns: std::ops::Range<usize>,
    rows: std::ops::Range<usize>,
    value: i8,
) {
    for row in rows {
        columns.clone().for_each(|column| grid.set(Cell::new(column, row), value).unwrap());
    }
}

fn laser(reach: f64) -> LaserScanner {
    let step = 2_f64.to_radians();
    let spec = LaserSpec {
        beams: 180,
        angle_min: -180_f64.to_radians(),
        angle_increment: step,
        range_max: reach,
        ..LaserSpec::sick_lms100()
    };
    LaserScanner::new(spec).unwrap()
}

/// Drives along poses, and returns the filter after each update.
fn drive(
    map: &OccupancyGrid,
    laser: &LaserScanner,
    seed: u64,
    path: impl Iterator<Item = Pose2>,
    mut each: impl FnMut(&Mcl, Pose2),
) {
    let mut mcl = Mcl::new(map, MclSettings::default(), stream(seed, "mcl")).unwrap();
    let mut noise = stream(seed, "laser");
    for truth in path {
        let scan = laser.scan(map, truth, &mut noise);
        update(&mut mcl, truth, &scan);
        each(&mcl, truth);
    }
}

/// First nothing is in sight, then one bare wall, of four that look the same: the belief stays
/// spread along what the scan leaves open, and says so.
#[test]
fn in_a_bare_hall_the_robot_stays_lost() {
    let (map, laser) = (hall(30.0, 30.0), laser(6.0));
    for seed in 0..3 {
        let path = (0..90).map(|k| Pose2::new(15.0 + 0.15 * f64::from(k), 14.0, 0.1));
        let (mut lost, mut far) = (Vec::new(), 0);
        drive(&map, &laser, seed, path, |mcl, truth| {
            lost.push(mcl.lost());
            far += u32::from(mcl.pose().distance(truth) > 1.0);
            let sigma = mcl.belief().covariance.fixed_view::<2, 2>(0, 0).trace().sqrt();
            assert!(sigma > 1.0, "seed {seed}: sigma {sigma} m");
        });
        let min = lost.iter().copied().fold(1.0, f64::min);
        assert!(min > 0.3, "seed {seed}: lost down to {min}");
        assert!(far > 30, "seed {seed}: it is found by nothing");
    }
}

/// A room that is the same turned by 180 degrees: both hypotheses live.
#[test]
fn in_a_symmetric_room_both_hypotheses_live() {
    let mut map = hall(12.0, 8.0);
    fill(&mut map, 30..44, 30..40, 100);
    fill(&mut map, 240 - 44..240 - 30, 160 - 40..160 - 30, 100);
    fill(&mut map, 60..70, 110..118, 100);
    fill(&mut map, 240 - 70..240 - 60, 160 - 118..160 - 110, 100);
    let laser = laser(20.0);
    for seed in 0..4 {
        let around = |k: i32| {
            let t = 0.04 * f64::from(k);
            Pose2::new(6.0 + 2.5 * t.cos(), 4.0 + 1.2 * t.sin(), angle::wrap(t))
        };
        let mut shares: Vec<f64> = Vec::new();
        drive(&map, &laser, seed, (0..150).map(around), |mcl, truth| {
            let clusters = &mcl.last_estimate().clusters;
            let turned = Pose2::new(
                12.0 - truth.x,
                8.0 - truth.y,
                angle::wrap(truth.theta + std::f64::consts::PI),
            );
            let share = |at: Pose2| -> f64 {
                let near = clusters.iter().filter(|c| c.belief.pose().distance(at) < 0.5);
                near.map(|c| c.share).sum()
            };
            shares.push(share(truth).min(share(turned)));
        });
        let min = shares.iter().skip(3).copied().fold(1.0, f64::min);
        assert!(min > 0.02, "seed {seed}: a hypothesis fell to {min}");
    }
}

/// Encoders that stick: the scans move the pose, and the filter says so.
#[test]
fn the_scans_move_a_robot_whose_encoders_stick() {
    for seed in 0..3 {
        let map = office(2);
        let mut robot = Robot::new(&map, Robot::laser(), seed);
        let mut mcl = Mcl::new(&map, MclSettings::default(), stream(seed, "mcl")).unwrap();
        mcl.start_at(&pose_belief(robot.truth, [0.1, 0.1, 0.05])).unwrap();
        for _ in 0..10 {
            robot.drive();
            let scan = robot.scan();
            update(&mut mcl, robot.odometry, &scan);
        }
        let stuck = robot.odometry;
        let (mut worst, mut driven): (f64, f64) = (0.0, 0.0);
        for _ in 0..40 {
            let before = robot.truth;
            robot.drive();
            driven += robot.error(before).0;
            // Ten scans for each step, as of a laser at 20 Hz on a robot at 0.4 m/s.
            for _ in 0..10 {
                let scan = robot.scan();
                update(&mut mcl, stuck, &scan);
            }
            worst = worst.max(robot.error(mcl.pose()).0);
        }
        assert!(driven > 1.0, "seed {seed}: the robot moved by {driven} m only");
        assert!(worst < 0.8, "seed {seed}: {worst} m off");
        assert!(robot.error(mcl.pose()).0 < 0.3, "seed {seed}: {:?}", robot.error(mcl.pose()));
        assert!(mcl.notes().join("\n").contains("while the odometry stood still"));
    }
}

/// A robot that stands costs nothing, and moves nothing.
#[test]
fn a_robot_that_stands_is_left_alone() {
    let map = office(2);
    let mut robot = Robot::new(&map, Robot::laser(), 5);
    let mut mcl = Mcl::new(&map, MclSettings::default(), stream(5, "mcl")).unwrap();
    mcl.start_at(&pose_belief(robot.truth, [0.1, 0.1, 0.05])).unwrap();
    let scan = robot.scan();
    update(&mut mcl, robot.odometry, &scan);
    for _ in 0..200 {
        let scan = robot.scan();
        assert_eq!(update(&mut mcl, robot.odometry, &scan), Update::StoodStill);
    }
}

/// Off the map the pose follows the odometry with a covariance that grows, no scan throws it
/// elsewhere, and back on the map the robot is taken up again.
#[test]
fn off_the_map_the_robot_coasts() {
    let whole = hall(24.0, 6.0);
    let mut whole = whole;
    // Pillars, so that the place along the hall is seen.
    for k in 0..7_usize {
        fill(&mut whole, 40 + 62 * k..48 + 62 * k, 20 + 9 * (k % 3)..28 + 9 * (k % 3), 100);
    }
    let mut half = whole.clone();
    fill(&mut half, 240..480, 0..120, -1);
    let laser = laser(8.0);
    for seed in 0..3 {
        let mut mcl = Mcl::new(&half, MclSettings::default(), stream(seed, "mcl")).unwrap();
        mcl.start_at(&pose_belief(Pose2::new(3.0, 4.2, 0.0), [0.1, 0.1, 0.05])).unwrap();
        let mut noise = stream(seed, "laser");
        // There at 4.2 m, where it turns, and back.
        let there = (0..110).map(|k| Pose2::new(3.0 + 0.16 * f64::from(k), 4.2, 0.0));
        let turn = (1..16).map(|k| Pose2::new(20.44, 4.2, angle::wrap(0.2 * f64::from(k) + 0.1)));
        let back = (0..110).map(|k| Pose2::new(20.44 - 0.16 * f64::from(k), 4.2, 3.1));
        let (mut odometry, mut last) = (Pose2::IDENTITY, Pose2::new(3.0, 4.2, 0.0));
        let (mut sigma, mut far): (f64, f64) = (0.0, 0.0);
        for truth in there.chain(turn).chain(back) {
            let step = last.between(truth);
            odometry = odometry * Pose2::new(1.01 * step.x, step.y, step.theta);
            last = truth;
            let scan = laser.scan(&whole, truth, &mut noise);
            update(&mut mcl, odometry, &scan);
            let belief = mcl.belief().covariance;
            sigma = sigma.max((belief.m11 + belief.m22).sqrt());
            far = far.max(mcl.pose().distance(truth));
            let is_sure = mcl.lost() < 0.1 && (belief.m11 + belief.m22).sqrt() < 0.1;
            let error = mcl.pose().distance(truth);
            eprintln!(
                "{seed} {truth} {} err {error:.2} lost {:.2} s {:.2}",
                mcl.pose(),
                mcl.lost(),
                (belief.m11 + belief.m22).sqrt()
            );
            assert!(!is_sure || error < 0.5, "seed {seed} at {truth}: {error} m");
        }
        assert!(sigma > 0.15 && far < 1.0, "seed {seed}: sigma {sigma} m, {far} m off");
        assert!(mcl.pose().distance(last) < 0.1 && mcl.lost() < 0.1, "seed {seed}: {}", mcl.pose());
    }
}

/// What a map says about where beams end.
#[test]
fn beams_leave_the_map_only_into_the_unknown() {
    let mut map = hall(10.0, 10.0);
    // The right half is unknown, but for a wall at 7 m from the left.
    fill(&mut map, 100..200, 0..200, -1);
    fill(&mut map, 140..142, 0..100, 100);
    let rater = ScanRater::new(&map, &mut stream(1, "rater")).unwrap();
    let laser = Pose2::new(3.0, 3.0, 0.0);
    let leaves = |degrees: f64, range: f64| {
        rater.leaves_map(laser, &Beam { index: 0, angle: degrees.to_radians(), range })
    };
    // To the left wall, in front of it and behind it.
    assert!(!leaves(180.0, 2.9) && !leaves(180.0, 1.0) && !leaves(180.0, 4.0));
    // Into the unknown space at 5 m, and just to its edge.
    assert!(leaves(0.0, 3.5) && !leaves(0.0, 2.0) && !leaves(0.0, 2.2));
    // A robot in the unknown space: towards nothing, and to the wall that is known there.
    let inside = Pose2::new(6.0, 3.0, 0.0);
    let beam = |range: f64| Beam { index: 0, angle: 0.0, range };
    assert!(!rater.leaves_map(inside, &beam(1.0)) && rater.leaves_map(inside, &beam(0.5)));
}
