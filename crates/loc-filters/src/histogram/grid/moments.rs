//! Mean and covariance of weighted poses.

use loc_core::{Gaussian, Pose2, angle};
use nalgebra::{Matrix3, Vector3};

/// Sums over weighted poses, from which mean and covariance follow.
///
/// Headings are averaged as directions; their deviations are those from the mean direction.
#[derive(Debug, Clone, Default)]
pub(super) struct Moments {
    poses: Vec<(Pose2, f64)>,
}

impl Moments {
    pub(super) fn add(&mut self, pose: Pose2, weight: f64) {
        self.poses.push((pose, weight));
    }

    /// The total weight.
    pub(super) fn total(&self) -> f64 {
        self.poses.iter().map(|(_, weight)| weight).sum()
    }

    /// Mean and covariance over (x, y, theta) of poses that each stand for a cell with this side
    /// \[m\] and sector \[rad\]; `None` without weight.
    pub(super) fn gaussian(&self, cell: f64, sector: f64) -> Option<Gaussian<3>> {
        let total = self.total();
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let mean = |of: fn(Pose2) -> f64| {
            self.poses.iter().map(|(pose, weight)| weight * of(*pose)).sum::<f64>() / total
        };
        let (x, y) = (mean(|pose| pose.x), mean(|pose| pose.y));
        let headings = self.poses.iter().map(|(pose, weight)| (pose.theta, *weight));
        let theta = angle::weighted_circular_mean(headings).unwrap_or(0.0);
        let mut covariance = Matrix3::zeros();
        for (pose, weight) in &self.poses {
            let off = Vector3::new(pose.x - x, pose.y - y, angle::difference(pose.theta, theta));
            covariance += off * off.transpose() * (weight / total);
        }
        // A cell is as likely in all of its extent.
        let of_cell = Vector3::new(cell * cell, cell * cell, sector * sector) / 12.0;
        covariance += Matrix3::from_diagonal(&of_cell);
        Some(Gaussian { mean: Vector3::new(x, y, theta), covariance })
    }
}
