//! What a cloud says about the pose: mean, covariance, clusters, and whether to believe it.

use crate::Particles;
use loc_core::{Gaussian, Pose2, angle};
use nalgebra::{Matrix3, Vector3};

/// What a cloud says about the pose.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Mean and covariance over (x, y, theta) \[m, m, rad\].
    pub belief: Gaussian<3>,
}

/// Weighted mean and covariance of all particles; the heading's mean is the direction of the sum
/// of unit vectors, its deviations are wrapped. Weights must be normalised.
pub fn moments(particles: &Particles) -> Gaussian<3> {
    let (mut x, mut y, mut sin, mut cos) = (0.0, 0.0, 0.0, 0.0);
    for (pose, weight) in particles.poses().iter().zip(particles.weights()) {
        x += weight * pose.x;
        y += weight * pose.y;
        sin += weight * pose.theta.sin();
        cos += weight * pose.theta.cos();
    }
    let mean = Pose2::new(x, y, sin.atan2(cos));
    let mut covariance = Matrix3::zeros();
    for (pose, weight) in particles.poses().iter().zip(particles.weights()) {
        let turn = angle::difference(pose.theta, mean.theta);
        let deviation = Vector3::new(pose.x - mean.x, pose.y - mean.y, turn);
        covariance += weight * deviation * deviation.transpose();
    }
    Gaussian { mean: mean.to_vector(), covariance }
}
