//! A robot followed on a grid over (x, y, heading).

use super::robot::{Robot, office};
use loc_core::gaussian::pose_belief;
use loc_core::{Pose2, angle};
use loc_filters::histogram::{GridLocalizer, GridSettings, GridUpdate};

fn update(localizer: &mut GridLocalizer, robot: &mut Robot<'_>) -> GridUpdate {
    let scan = robot.scan();
    localizer.update(robot.odometry, &scan, Pose2::IDENTITY).unwrap()
}

fn is_found(localizer: &GridLocalizer, robot: &Robot<'_>) -> bool {
    let pose = localizer.belief().pose();
    let turned = angle::difference(pose.theta, robot.truth.theta).abs();
    pose.distance(robot.truth) < 0.2 && turned < 5_f64.to_radians()
}

/// From no knowledge, over several seeds; then followed to a few centimetres, then carried off.
#[test]
fn a_robot_is_found_followed_and_found_again() {
    let map = office();
    let mut localizer = GridLocalizer::new(&map, GridSettings::default()).unwrap();
    let mut errors = Vec::new();
    for seed in 0..3 {
        let mut robot = Robot::new(&map, seed);
        localizer.start_anywhere();
        assert_eq!((localizer.anywhere(), localizer.certainty()), (1.0, 0.0));
        for kidnapped in [false, true] {
            if kidnapped {
                robot.carry_off();
            }
            let mut scans = 0;
            while !is_found(&localizer, &robot) {
                robot.drive();
                update(&mut localizer, &mut robot);
                scans += 1;
                assert!(scans <= 5, "seed {seed}, kidnapped {kidnapped}");
            }
            println!("seed {seed}, kidnapped {kidnapped}: found after {scans}");
            for _ in 0..4 {
                robot.drive();
                update(&mut localizer, &mut robot);
                errors.push(localizer.belief().pose().distance(robot.truth));
                assert!(localizer.certainty() > 0.9);
            }
        }
    }
    errors.sort_by(f64::total_cmp);
    println!("median {:.3} m, largest {:.3} m", errors[errors.len() / 2], errors[errors.len() - 1]);
    assert!(errors[errors.len() / 2] < 0.03 && errors[errors.len() - 1] < 0.15, "{errors:?}");
}

/// The covariance says how far the estimate is off, within a factor.
#[test]
fn the_covariance_is_honest() {
    let map = office();
    let mut localizer = GridLocalizer::new(&map, GridSettings::default()).unwrap();
    let (mut sum, mut count) = (0.0, 0);
    for seed in 10..14 {
        let mut robot = Robot::new(&map, seed);
        localizer.start_at(&pose_belief(robot.truth, [0.1, 0.1, 0.05])).unwrap();
        for _ in 0..5 {
            robot.drive();
            update(&mut localizer, &mut robot);
            let estimate = localizer.belief();
            let off = estimate.pose_deviation(robot.truth);
            sum += off.dot(&(estimate.covariance.try_inverse().unwrap() * off));
            count += 1;
        }
    }
    let nees = sum / f64::from(count);
    println!("mean NEES {nees:.2} over {count} updates");
    assert!((0.3..4.0).contains(&nees), "{nees}");
}

#[test]
fn the_belief_adds_up_and_the_whole_map_can_be_read() {
    let map = office();
    let mut localizer = GridLocalizer::new(&map, GridSettings::default()).unwrap();
    let mut robot = Robot::new(&map, 5);
    let sum = |localizer: &GridLocalizer| localizer.position_probabilities().iter().sum::<f64>();
    assert!((sum(&localizer) - 1.0).abs() < 1e-9);
    // Nothing is known: the middle of the free area, and any heading.
    let mean = localizer.mean();
    assert!((mean.covariance.m33 - std::f64::consts::PI.powi(2) / 3.0).abs() < 0.01);
    assert!(mean.covariance.m11.sqrt() > 3.0);
    update(&mut localizer, &mut robot);
    assert!((sum(&localizer) - 1.0).abs() < 1e-9);
    let probabilities = localizer.position_probabilities();
    let most =
        (0..probabilities.len()).max_by(|a, b| probabilities[*a].total_cmp(&probabilities[*b]));
    let squares = localizer.squares();
    let at = squares.cell_at(&robot.truth.position()).and_then(|cell| squares.index(cell));
    let width = squares.width() as isize;
    let apart = most.unwrap() as isize - at.unwrap() as isize;
    assert!([0, 1, width, width + 1, width - 1].contains(&apart.abs()), "{apart}");
    let hypotheses = localizer.peaks(3);
    assert!(hypotheses.len() <= 3 && hypotheses[0].0 == localizer.certainty());
    assert!(hypotheses.windows(2).all(|pair| pair[0].0 >= pair[1].0));
}

/// Nothing is drawn: the same inputs give the same belief, to the bit.
#[test]
fn it_is_the_same_every_time() {
    let map = office();
    let run = || {
        let mut localizer = GridLocalizer::new(&map, GridSettings::default()).unwrap();
        let mut robot = Robot::new(&map, 8);
        for _ in 0..2 {
            robot.drive();
            update(&mut localizer, &mut robot);
        }
        (localizer.belief(), localizer.position_probabilities())
    };
    assert_eq!(run(), run());
}

/// A robot that hardly moves uses one scan; odometry alone carries the estimate along.
#[test]
fn a_robot_at_rest_takes_in_one_scan() {
    let map = office();
    let mut localizer = GridLocalizer::new(&map, GridSettings::default()).unwrap();
    let mut robot = Robot::new(&map, 2);
    localizer.start_at(&pose_belief(robot.truth, [0.05, 0.05, 0.02])).unwrap();
    assert!(matches!(update(&mut localizer, &mut robot), GridUpdate::Done(_)));
    assert_eq!(update(&mut localizer, &mut robot), GridUpdate::StoodStill);
    let before = localizer.belief();
    let step = Pose2::new(0.05, 0.0, 0.02);
    localizer.odometry(robot.odometry * step).unwrap();
    let after = localizer.belief();
    assert!(after.pose().distance(before.pose() * step) < 1e-12);
    assert!(after.covariance.trace() > before.covariance.trace());
}
