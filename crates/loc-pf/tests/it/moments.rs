//! Mean and covariance of clouds.

use approx::assert_abs_diff_eq;
use loc_core::random::stream;
use loc_core::{Gaussian, Pose2, angle};
use loc_pf::Particles;
use loc_pf::estimate::moments;
use nalgebra::{Matrix3, Vector3};
use rand::RngExt;
use std::f64::consts::PI;

fn cloud(particles: &[(Pose2, f64)]) -> Particles {
    let mut cloud = Particles::new();
    particles.iter().for_each(|&(pose, weight)| cloud.push(pose, weight.ln()));
    cloud
}

/// The definition, with the sines of the standard library.
fn plain(particles: &Particles) -> Gaussian<3> {
    let total: f64 = particles.weights().sum();
    let poses = particles.poses();
    let pairs = || poses.iter().zip(particles.weights());
    let mean_of = |part: fn(Pose2) -> f64| pairs().map(|(p, w)| w * part(p)).sum::<f64>() / total;
    let heading = mean_of(|p| p.theta.sin()).atan2(mean_of(|p| p.theta.cos()));
    let mean = Vector3::new(mean_of(|p| p.x), mean_of(|p| p.y), heading);
    let mut covariance = Matrix3::zeros();
    for (pose, weight) in pairs() {
        let mut deviation = pose.to_vector() - mean;
        deviation.z = angle::wrap(deviation.z);
        covariance += weight / total * deviation * deviation.transpose();
    }
    Gaussian { mean, covariance }
}

#[test]
fn two_particles_by_hand() {
    // Weights 1 : 3, so the mean lies at 3/4 of the way and the variance is 3/16 of its square.
    let two = [(Pose2::new(1.0, 2.0, 0.1), 0.5), (Pose2::new(5.0, 0.0, 0.1), 1.5)];
    let belief = moments(&cloud(&two));
    assert_abs_diff_eq!(belief.mean, Vector3::new(4.0, 0.5, 0.1), epsilon = 1e-12);
    let expected = Matrix3::new(3.0, -1.5, 0.0, -1.5, 0.75, 0.0, 0.0, 0.0, 0.0);
    assert_abs_diff_eq!(belief.covariance, expected, epsilon = 1e-12);
}

#[test]
fn headings_across_pi_are_close_together() {
    let two = [(Pose2::new(0.0, 0.0, PI - 0.1), 1.0), (Pose2::new(0.0, 1.0, -PI + 0.2), 1.0)];
    let belief = moments(&cloud(&two));
    assert_abs_diff_eq!(belief.mean.z, -PI + 0.05, epsilon = 1e-12);
    assert_abs_diff_eq!(belief.covariance.m33, 0.0225, epsilon = 1e-12);
    assert_abs_diff_eq!(belief.covariance.m23, 0.075, epsilon = 1e-12);
}

#[test]
fn any_particle_set_by_the_definition() {
    let mut rng = stream(3, "cloud");
    for count in [1, 2, 3, 4, 5, 7, 64, 1001] {
        for spread in [0.1, 1.0, 3.1] {
            let mut particles = Particles::new();
            for _ in 0..count {
                let mut draw = |width: f64| width * (2.0 * rng.random::<f64>() - 1.0);
                let pose = Pose2::new(300.0 + draw(5.0), -40.0 + draw(9.0), 3.0 + draw(spread));
                particles.push(pose, -900.0 + draw(9.0));
            }
            let fast = moments(&particles);
            particles.normalize();
            let slow = plain(&particles);
            assert_abs_diff_eq!(fast.pose_deviation(slow.pose()), Vector3::zeros(), epsilon = 1e-9);
            assert_abs_diff_eq!(fast.covariance, slow.covariance, epsilon = 1e-9);
            assert!(Gaussian::new(fast.mean, fast.covariance).is_ok());
        }
    }
}

#[test]
fn a_heading_that_is_not_known_has_the_variance_of_a_whole_turn() {
    let opposite = [(Pose2::new(1.0, 0.0, 0.5), 1.0), (Pose2::new(3.0, 0.0, 0.5 - PI), 1.0)];
    let all_round = (0..8)
        .map(|k| (Pose2::new(f64::from(k % 2) * 2.0 + 1.0, 0.0, f64::from(k) * PI / 4.0), 1.0));
    for particles in [opposite.to_vec(), all_round.collect()] {
        let belief = moments(&cloud(&particles));
        assert_abs_diff_eq!(belief.mean, Vector3::new(2.0, 0.0, 0.0), epsilon = 1e-12);
        let expected = Matrix3::from_diagonal(&Vector3::new(1.0, 0.0, PI * PI / 3.0));
        assert_abs_diff_eq!(belief.covariance, expected, epsilon = 1e-12);
    }
}

#[test]
fn what_is_no_pose_or_has_no_weight_counts_for_nothing() {
    let good = (Pose2::new(1.0, 2.0, 3.0), 1.0);
    let bad = |x, y, theta| (Pose2 { x, y, theta }, 1.0);
    let nowhere = bad(f64::NAN, 0.0, 0.0);
    let far = bad(0.0, f64::INFINITY, 0.0);
    let turned = bad(0.0, 0.0, f64::NAN);
    let weightless = (Pose2::new(9.0, 9.0, 0.0), 0.0);
    let mut particles = cloud(&[nowhere, good, far, turned, weightless]);
    particles.push(Pose2::new(7.0, 7.0, 1.0), f64::NAN);
    let belief = moments(&particles);
    assert_abs_diff_eq!(belief.mean, Vector3::new(1.0, 2.0, 3.0), epsilon = 1e-12);
    assert_abs_diff_eq!(belief.covariance, Matrix3::zeros(), epsilon = 1e-12);

    for particles in [Particles::new(), cloud(&[nowhere, far])] {
        let belief = moments(&particles);
        assert_eq!(belief.mean, Vector3::zeros());
        assert_abs_diff_eq!(belief.covariance.m33, PI * PI / 3.0, epsilon = 1e-12);
    }
    // Weights that are all 0 are as good as equal ones.
    let belief = moments(&cloud(&[(Pose2::new(1.0, 0.0, 0.0), 0.0), (Pose2::IDENTITY, 0.0)]));
    assert_abs_diff_eq!(belief.mean.x, 0.5, epsilon = 1e-12);
}
