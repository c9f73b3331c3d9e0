//! The normalised error of one estimate.

use crate::localizer::Estimate;
use loc_core::{Gaussian, Pose2};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// A covariance whose determinant is smaller than this share of the product of its variances, is
/// singular but for rounding.
const SINGULAR: f64 = 1e-12;

/// Normalised estimation error squared of a pose, over the coordinates that the method is not
/// certain of: chi-square distributed with as many degrees of freedom, 3 for a pose in the plane.
///
/// `None` without a covariance, where nothing is uncertain, or where the covariance is singular but
/// for rounding.
pub fn pose_nees(estimate: &Estimate, truth: Pose2) -> Option<f64> {
    pose_nees_with_freedom(estimate, truth).map(|(_, nees)| nees)
}

/// Degrees of freedom and NEES of a pose, see [`pose_nees`].
pub fn pose_nees_with_freedom(estimate: &Estimate, truth: Pose2) -> Option<(usize, f64)> {
    let covariance = estimate.covariance?;
    let belief = Gaussian { mean: estimate.pose.to_vector(), covariance };
    let error = belief.pose_deviation(truth);
    if covariance.diagonal().iter().all(|variance| *variance > 0.0) {
        let singular = determinant_share(&covariance) < SINGULAR;
        return if singular { None } else { whole(&error, &covariance) };
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

fn whole(error: &Vector3<f64>, covariance: &Matrix3<f64>) -> Option<(usize, f64)> {
    loc_core::stats::nees(error, covariance).ok().map(|nees| (3, nees))
}

/// The determinant by the product of the variances: 1 where nothing is correlated.
fn determinant_share(covariance: &Matrix3<f64>) -> f64 {
    covariance.determinant() / covariance.diagonal().product()
}
