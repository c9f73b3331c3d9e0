//! What SLAM cannot know: where north is. Two of three filters keep it that way.

use loc_core::gaussian::pose_belief;
use loc_core::motion::VelocityNoise;
use loc_core::random::stream;
use loc_core::{Pose2, Twist2};
use loc_filters::RobotSettings;
use loc_filters::slam::{EkfSlam, Jacobians, SlamSettings};
use loc_sensors::landmark_camera::LandmarkCamera;
use loc_sensors::world::Landmarks;
use nalgebra::DMatrix;

/// The information about a shift and a turn of everything together, `N^T P^-1 N`. With perfect
/// odometry it cannot change, since no observation tells of it.
fn information_of_the_whole(jacobians: Jacobians) -> (DMatrix<f64>, DMatrix<f64>) {
    let settings = SlamSettings::default()
        .robot(RobotSettings::default().odometry(VelocityNoise::NONE))
        .jacobians(jacobians);
    let world = Landmarks::from([(1, [3.0, 1.0]), (2, [2.0, -2.0]), (3, [-1.0, 2.5])]);
    let start = pose_belief(Pose2::IDENTITY, [0.2, 0.2, 0.1]);
    let mut slam = EkfSlam::new(start, settings).unwrap();
    let mut before = DMatrix::zeros(3, 3);
    (0..3).for_each(|k| before[(k, k)] = 1.0 / start.covariance[(k, k)]);
    let (mut rng, mut truth) = (stream(2, "camera"), Pose2::new(0.15, -0.1, 0.12));
    let mut first: Vec<[f64; 2]> = Vec::new();
    let mut anchor = Pose2::IDENTITY;
    for _ in 0..60 {
        let twist = Twist2::forward(0.4, 0.5);
        truth = settings.robot.integration.step(truth, twist, 0.2);
        slam.predict(twist, 0.2).unwrap();
        anchor = slam.pose().unwrap().pose();
        slam.correct(&LandmarkCamera::default().observe(&world, truth, &mut rng)).unwrap();
        let born =
            slam.landmarks().unwrap().into_iter().skip(first.len()).map(|l| l.position.mean.into());
        let born: Vec<[f64; 2]> = born.collect();
        first.extend(born);
    }
    let mut n = DMatrix::zeros(3 + 2 * first.len(), 3);
    if jacobians == Jacobians::Invariant {
        // This one counts errors from where everything is now.
        anchor = slam.pose().unwrap().pose();
        first = slam.landmarks().unwrap().into_iter().map(|l| l.position.mean.into()).collect();
    }
    let places = [[anchor.x, anchor.y]].into_iter().chain(first);
    for (k, [x, y]) in places.enumerate() {
        let row = if k == 0 { 0 } else { 1 + 2 * k };
        (n[(row, 0)], n[(row + 1, 1)]) = (1.0, 1.0);
        (n[(row, 2)], n[(row + 1, 2)]) = (-y, x);
    }
    n[(2, 2)] = 1.0;
    let information = slam.covariance().unwrap().try_inverse().unwrap();
    (before, n.transpose() * information * n)
}

#[test]
fn first_estimates_learn_nothing_about_north() {
    let (before, after) = information_of_the_whole(Jacobians::First);
    assert!((&after - &before).amax() < 1e-5 * before.amax(), "{before}{after}");
}

#[test]
fn the_invariant_filter_learns_nothing_about_north() {
    let (before, after) = information_of_the_whole(Jacobians::Invariant);
    assert!((&after - &before).amax() < 1e-5 * before.amax(), "{before}{after}");
}

#[test]
fn the_textbook_believes_that_it_has() {
    let (before, after) = information_of_the_whole(Jacobians::Current);
    assert!(after[(2, 2)] > 1.3 * before[(2, 2)], "{before}{after}");
}
