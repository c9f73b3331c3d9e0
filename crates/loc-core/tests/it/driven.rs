//! A driven path and the noise of its odometry.

use crate::finite_difference::jacobian;
use approx::{assert_abs_diff_eq, assert_relative_eq};
use loc_core::motion::{DrivenPath, PathNoise};
use loc_core::{Gaussian, Pose2};
use nalgebra::Vector3;

fn path(poses: &[Pose2]) -> DrivenPath {
    let mut path = DrivenPath::starting_at(poses[0]);
    poses[1..].iter().for_each(|pose| path.extend(*pose));
    path
}

/// Out and back: the way counts, not where it ends.
#[test]
fn variances_add_up_along_the_way() {
    let turned = Pose2::new(2.0, 0.0, 0.5);
    let there_and_back = path(&[Pose2::IDENTITY, turned, Pose2::IDENTITY]);
    assert_eq!((there_and_back.length(), there_and_back.turned()), (4.0, 1.0));
    let noise = PathNoise { along: 0.1, across: 0.2, pivot: 0.05, ..PathNoise::default() };
    let variances = noise.variances(&there_and_back);
    assert_relative_eq!(variances.x, 4.0 * 0.01 + 0.0025, epsilon = 1e-15);
    assert_relative_eq!(variances.y, 4.0 * 0.04 + 0.0025, epsilon = 1e-15);
    let heading = 4.0 * 3_f64.to_radians().powi(2) + 5_f64.to_radians().powi(2);
    assert_relative_eq!(variances.z, heading, epsilon = 1e-15);
}

#[test]
fn the_step_is_linearised_right() {
    let way = path(&[Pose2::new(1.0, 2.0, 0.4), Pose2::new(1.8, 2.6, 1.1)]);
    let pose = Pose2::new(-3.0, 5.0, 2.9);
    let step = PathNoise::step(&way, pose, &Vector3::new(0.01, 0.02, 0.03));
    let moved = |x: Vector3<f64>| (Pose2::from_vector(&x) * way.step()).to_vector();
    let numeric = jacobian(moved, pose.to_vector(), Some(2));
    assert_abs_diff_eq!(step.by_pose, numeric, epsilon = 1e-8);
    assert_eq!(step.pose, pose * way.step());
    // An error of the heading comes to be evenly on the way: half of it turns the whole step.
    let erring = |error: Vector3<f64>| {
        let turn = Pose2::new(0.0, 0.0, 0.5 * error.z);
        let at_the_end = Pose2::new(error.x, error.y, 0.0);
        let end = pose * at_the_end * turn * way.step() * turn;
        end.to_vector()
    };
    let by_noise = jacobian(erring, Vector3::zeros(), Some(2));
    let variances = nalgebra::Matrix3::from_diagonal(&Vector3::new(0.01, 0.02, 0.03));
    let noise = by_noise * variances * by_noise.transpose();
    assert_abs_diff_eq!(step.noise, noise, epsilon = 1e-8);
}

/// E7: however many steps a straight way is cut into, heading and distance vary as much.
#[test]
fn cutting_a_way_changes_little() {
    let noise = PathNoise::default();
    let ahead = |x: f64| Pose2::new(x, 0.0, 0.0);
    let start = Gaussian::certain(Pose2::IDENTITY.to_vector());
    let whole = noise.belief_after(&path(&[ahead(0.0), ahead(2.0)]), &start);
    let cut = (0..200).fold(start, |belief, k| {
        let step = path(&[ahead(0.01 * f64::from(k)), ahead(0.01 * f64::from(k + 1))]);
        noise.belief_after(&step, &belief)
    });
    assert_relative_eq!(whole.covariance.m11, cut.covariance.m11, epsilon = 1e-12);
    assert_relative_eq!(whole.covariance.m33, cut.covariance.m33, epsilon = 1e-12);
    assert_relative_eq!(whole.covariance.m23, cut.covariance.m23, max_relative = 0.01);
    // Half the turn over the whole way has 3/4 of the variance across of turns along the way.
    let drift = noise.drift.powi(2);
    assert_relative_eq!(
        cut.covariance.m22 - 2.0 * noise.across.powi(2),
        8.0 / 3.0 * drift,
        max_relative = 0.01
    );
    assert_relative_eq!(
        whole.covariance.m22 - 2.0 * noise.across.powi(2),
        2.0 * drift,
        max_relative = 1e-9
    );
}

#[test]
fn bad_noise_is_named() {
    for (noise, message) in [
        (PathNoise { along: -1.0, ..PathNoise::default() }, "noise along the way"),
        (PathNoise { turn: f64::NAN, ..PathNoise::default() }, "noise of turning"),
        (PathNoise { fault_probability: 1.5, ..PathNoise::default() }, "odometry fault"),
    ] {
        assert!(noise.validate().unwrap_err().to_string().contains(message));
    }
}
