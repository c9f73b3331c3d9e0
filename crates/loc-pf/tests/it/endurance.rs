//! A million updates: neither weights nor memory drift.

use crate::robot::{Robot, office};
use loc_core::gaussian::pose_belief;
use loc_core::random::stream;
use loc_core::{Pose2, angle};
use loc_pf::mcl::{MountedScan, Update};
use loc_pf::{Mcl, MclSettings};
use loc_sensors::laser::LaserScan;
use rand_distr::{Distribution, StandardNormal};

const UPDATES: usize = 1_000_000;

/// Places of the round that the robot drives again and again, with the scan at each.
const ROUND: usize = 500;

/// Memory of this process \[kB\], where the system tells.
fn memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    line.split_whitespace().nth(1)?.parse().ok()
}

/// There and back: the last place is the first one.
fn round(robot: &mut Robot) -> Vec<(Pose2, LaserScan)> {
    let mut places = Vec::new();
    for _ in 0..ROUND {
        robot.drive();
        places.push((robot.truth, robot.scan()));
    }
    let back: Vec<_> = places.iter().rev().cloned().collect();
    places.into_iter().chain(back).collect()
}

/// `cargo test --release -p loc-pf -- --ignored --nocapture endurance`
#[test]
#[ignore = "a million updates: ten minutes in a release build"]
fn a_million_updates_leave_weights_and_memory_as_they_are() {
    let map = office(1);
    let mut robot = Robot::new(&map, Robot::laser(), 1);
    let mut truth = robot.truth;
    let mut mcl = Mcl::new(&map, MclSettings::default(), stream(1, "mcl")).unwrap();
    mcl.start_at(&pose_belief(truth, [0.2, 0.2, 0.1])).unwrap();
    let places = round(&mut robot);
    let mut rng = stream(1, "odometry");
    let mut odometry = Pose2::IDENTITY;
    let (mut done, mut used) = (0, None);
    let mut errors = Vec::new();
    let mut sum = 0.0;
    for k in 0.. {
        let (next, scan) = &places[k % places.len()];
        let step = truth.between(*next);
        let [a, b]: [f64; 2] = std::array::from_fn(|_| StandardNormal.sample(&mut rng));
        odometry = odometry * Pose2::new(step.x + 0.01 * a, step.y, step.theta + 0.01 * b);
        truth = *next;
        let scan = MountedScan { scan, mounting: Pose2::IDENTITY };
        let Update::Done(_) = mcl.update(odometry, &[scan]).unwrap() else { continue };
        done += 1;
        let weights: f64 = mcl.particles().weights().sum();
        assert!((weights - 1.0).abs() < 1e-9 && mcl.pose().is_finite(), "{done}: {weights}");
        assert!(mcl.particles().len() <= 4000, "{done}: {}", mcl.particles().len());
        let off = angle::difference(mcl.pose().theta, truth.theta).abs();
        sum += mcl.pose().distance(truth) + off;
        // The first tenth is when buffers have grown to their size.
        if done % (UPDATES / 10) == 0 {
            used = used.or_else(memory);
            errors.push(sum / (UPDATES / 10) as f64);
            sum = 0.0;
            println!("{done}: error {:.4}, memory {:?} kB", errors[errors.len() - 1], memory());
        }
        if done == UPDATES {
            break;
        }
    }
    assert!(errors[9] < 1.2 * errors[0] && errors[0] < 0.1, "{errors:?}");
    if let (Some(before), Some(after)) = (used, memory()) {
        assert!(after < 1.05 * before + 1000.0, "{before} kB, then {after} kB");
    }
}
