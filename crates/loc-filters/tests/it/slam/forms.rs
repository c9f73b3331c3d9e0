//! The forms of the filter: the invariant one, and errors that observations have in common.

use approx::assert_relative_eq;
use loc_core::gaussian::pose_belief;
use loc_core::{Gaussian, Pose2, Twist2};
use loc_filters::RobotSettings;
use loc_filters::localizer::Decision;
use loc_filters::slam::{EkfSlam, Identities, Jacobians, SlamSettings};
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use nalgebra::{DMatrix, Rotation2, Vector2};

fn see(landmark: u32, range: f64, bearing: f64) -> LandmarkObservation {
    LandmarkObservation { landmark, observed: Observed::RangeBearing { range, bearing } }
}

/// x, y of the robot and of the landmarks in turn, and the heading.
fn places(slam: &EkfSlam) -> (Vec<Vector2<f64>>, f64) {
    let robot = slam.pose().unwrap().mean;
    let landmarks = slam.landmarks().unwrap();
    let means = landmarks.iter().map(|landmark| landmark.position.mean);
    (std::iter::once(robot.xy()).chain(means).collect(), robot.z)
}

/// One correction by hand: the textbook's, carried to the new estimate with full matrices.
#[test]
fn the_invariant_correction_carries_that_of_the_textbook() {
    let seen = [see(1, 4.0, 0.3), see(2, 3.0, -0.8), see(3, 5.0, 1.1)];
    let [mut textbook, mut invariant] = [Jacobians::Current, Jacobians::Invariant].map(|form| {
        let settings = SlamSettings::default()
            .robot(RobotSettings::default().gate_probability(1.0))
            .jacobians(form);
        let start = pose_belief(Pose2::new(1.0, -2.0, 0.4), [0.1, 0.2, 0.3]);
        let mut slam = EkfSlam::new(start, settings).unwrap();
        slam.correct(&seen).unwrap();
        slam.predict(Twist2::forward(1.0, 0.6), 1.0).unwrap();
        slam
    });
    let (before, heading) = places(&textbook);
    let again = [see(1, 3.1, -0.1), see(3, 4.4, 0.9)];
    textbook.correct(&again).unwrap();
    invariant.correct(&again).unwrap();
    let ((added, turned), (carried, angle)) = (places(&textbook), places(&invariant));
    assert_relative_eq!(turned, angle, epsilon = 1e-12);
    let turn = turned - heading;
    assert!(turn.abs() > 0.05, "{turn}");
    // Each way is the mean of its directions from the start of the turn to its end.
    let steps = 2000;
    let mean_turn = (0..steps)
        .map(|k| *Rotation2::new(turn * (f64::from(k) + 0.5) / f64::from(steps)).matrix())
        .sum::<nalgebra::Matrix2<f64>>()
        / f64::from(steps);
    let size = 3 + 2 * (before.len() - 1);
    let mut a = DMatrix::identity(size, size);
    for (k, (from, to)) in before.iter().zip(&added).enumerate() {
        let way = mean_turn * (to - from);
        assert_relative_eq!(from + way, carried[k], epsilon = 1e-7);
        let row = if k == 0 { 0 } else { 1 + 2 * k };
        (a[(row, 2)], a[(row + 1, 2)]) = (-way.y, way.x);
    }
    let expected = &a * textbook.covariance().unwrap() * a.transpose();
    assert_relative_eq!(invariant.covariance().unwrap(), expected, epsilon = 1e-7);
}

/// Two landmarks in one direction: a common error of the distance shifts both alike.
#[test]
fn common_errors_cancel_between_landmarks() {
    for share in [0.0, 0.9] {
        let settings = SlamSettings::default().common_share(share);
        let start = Gaussian::certain(Pose2::IDENTITY.to_vector());
        let mut slam = EkfSlam::new(start, settings).unwrap();
        slam.correct(&[see(1, 4.0, 0.0), see(2, 5.0, 0.0)]).unwrap();
        let p = slam.covariance().unwrap();
        let noise = settings.robot.camera;
        let between = |k: usize| p[(k, k)] + p[(k + 2, k + 2)] - 2.0 * p[(k, k + 2)];
        let (range, bearing) = (noise.range_sigma.powi(2), noise.bearing_sigma.powi(2));
        assert_relative_eq!(p[(3, 3)], range, epsilon = 1e-12);
        assert_relative_eq!(between(3), 2.0 * (1.0 - share) * range, epsilon = 1e-12);
        let across = bearing * (41.0 * (1.0 - share) + share);
        assert_relative_eq!(between(4), across, epsilon = 1e-12);
    }
}

#[test]
fn what_stands_beside_a_known_landmark_is_new() {
    let settings = SlamSettings::default().identities(Identities::Unknown);
    let start = Gaussian::certain(Pose2::IDENTITY.to_vector());
    let mut slam = EkfSlam::new(start, settings).unwrap();
    for _ in 0..4 {
        slam.correct(&[see(0, 4.0, 0.0)]).unwrap();
    }
    // As far as observations of one landmark may lie apart: it may have been seen twice.
    let twice = slam.correct(&[see(0, 4.0, 0.0), see(0, 4.0, 0.02)]).unwrap();
    assert!(twice[0].accepted() && twice[1].decision == Decision::Ambiguous);
    let beside = slam.correct(&[see(0, 4.0, 0.0), see(0, 4.0, 0.06)]).unwrap();
    assert!(beside[0].accepted() && beside[1].decision == Decision::NewLandmark, "{beside:?}");
    assert_eq!(slam.len(), 2);
}

#[test]
fn forms_that_do_not_fit_are_refused() {
    let start = Gaussian::certain(Pose2::IDENTITY.to_vector());
    let base = SlamSettings::default();
    let refused = |settings| EkfSlam::new(start, settings).unwrap_err().to_string();
    let message = refused(base.submap_radius(Some(8.0)));
    assert!(message.contains("got `invariant`"), "{message}");
    for share in [1.0, -0.1, f64::NAN] {
        let message = refused(base.common_share(share));
        assert!(message.contains("SlamSettings.common_share"), "{message}");
    }
    let message = refused(base.common_time(0.0));
    assert!(message.contains("SlamSettings.common_time"), "{message}");
}
