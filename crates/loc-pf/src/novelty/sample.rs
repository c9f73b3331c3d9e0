//! A few poses that stand for a cloud.

use crate::Particles;
use loc_core::{Pose2, angle};
use nalgebra::{Matrix3, Vector3};

/// Poses of a cloud with weights that add up to 1.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BeliefSample {
    poses: Vec<Pose2>,
    weights: Vec<f64>,
}

impl BeliefSample {
    /// At most `count` particles, picked by their weights, evenly and without chance: a wheel of
    /// `count` spokes (M9) that stands still. The weights of the cloud must be normalised.
    ///
    /// Particles that several spokes meet are taken once, with the weight of all of them, so that
    /// a cloud of few different poses makes a small sample. An empty cloud makes an empty one.
    pub fn of(cloud: &Particles, count: usize) -> Self {
        let mut sample = BeliefSample::default();
        let each = 1.0 / count as f64;
        let (mut passed, mut spoke) = (0.0, 0.5 * each);
        for (pose, weight) in cloud.poses().iter().zip(cloud.weights()) {
            passed += weight;
            let met = ((passed - spoke) / each).ceil().max(0.0);
            if met > 0.0 && spoke < 1.0 {
                sample.poses.push(pose);
                sample.weights.push(met * each);
                spoke += met * each;
            }
        }
        let total: f64 = sample.weights.iter().sum();
        sample.weights.iter_mut().for_each(|weight| *weight /= total);
        sample
    }

    /// The poses.
    pub fn poses(&self) -> &[Pose2] {
        &self.poses
    }

    /// Their weights.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Logarithms of the belief's density at the poses, but for a constant: that of the Gaussian
    /// with the sample's mean and covariance.
    pub(super) fn log_densities(&self) -> Vec<f64> {
        let sum = |of: &dyn Fn(&Pose2) -> f64| -> f64 {
            self.poses.iter().zip(&self.weights).map(|(pose, weight)| weight * of(pose)).sum()
        };
        let (sin, cos) = (sum(&|pose| pose.theta.sin()), sum(&|pose| pose.theta.cos()));
        let mean = Pose2::new(sum(&|pose| pose.x), sum(&|pose| pose.y), sin.atan2(cos));
        let deviation = |pose: &Pose2| {
            let turn = angle::difference(pose.theta, mean.theta);
            Vector3::new(pose.x - mean.x, pose.y - mean.y, turn)
        };
        // A cloud without width along some direction has a little there.
        let mut covariance = Matrix3::identity() * 1e-12;
        for (pose, weight) in self.poses.iter().zip(&self.weights) {
            covariance += *weight * deviation(pose) * deviation(pose).transpose();
        }
        let Some(root) = covariance.cholesky() else { return vec![0.0; self.poses.len()] };
        let density = |pose| -0.5 * deviation(pose).dot(&root.solve(&deviation(pose)));
        self.poses.iter().map(density).collect()
    }
}
