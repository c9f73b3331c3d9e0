//! The normalised error of one estimate.

use crate::localizer::Estimate;
use loc_core::{Gaussian, Pose2};
use nalgebra::{DMatrix, DVector};

/// Normalised estimation error squared of a pose, over the coordinates that the method is not
/// certain of: chi-square distributed with as many degrees of freedom, 3 for a pose in the plane.
///
/// `None` without a covariance, where nothing is uncertain, or where the covariance is singular.
pub fn pose_nees(estimate: &Estimate, truth: Pose2) -> Option<f64> {
    pose_nees_with_freedom(estimate, truth).map(|(_, nees)| nees)
}

/// Degrees of freedom and NEES of a pose, see [`pose_nees`].
pub fn pose_nees_with_freedom(estimate: &Estimate, truth: Pose2) -> Option<(usize, f64)> {
    let covariance = estimate.covariance?;
    let belief = Gaussian { mean: estimate.pose.to_vector(), covariance };
    let error = belief.pose_deviation(truth);
    if covariance.diagonal().iter().all(|variance| *variance > 0.0) {
        return loc_core::stats::nees(&error, &covariance).ok().map(|nees| (3, nees));
    }
    let uncertain: Vec<usize> = (0..3).filter(|&i| covariance[(i, i)] > 0.0).collect();
    let n = uncertain.len();
    if n == 0 {
        return None;
    }
    let part = DMatrix::from_fn(n, n, |i, j| covariance[(uncertain[i], uncertain[j])]);
    let error = DVector::from_fn(n, |i, _| error[uncertain[i]]);
    Some((n, error.dot(&part.cholesky()?.solve(&error))))
}
