//! Dead reckoning with its growing uncertainty (E6).

use super::{Integration, Twist2, VelocityNoise};
use crate::{Gaussian, Pose2};

/// One step of dead reckoning: the mean moves by the integration rule, the covariance follows as
/// `S' = F_x S F_x^T + F_u S_u F_u^T`.
///
/// `belief` is over (x, y, theta) \[m, m, rad\], `dt` in \[s\].
// ANCHOR: dead-reckon
pub fn dead_reckon(
    belief: &Gaussian<3>,
    twist: Twist2,
    dt: f64,
    integration: Integration,
    noise: &VelocityNoise,
) -> Gaussian<3> {
    let pose = Pose2::from_vector(&belief.mean);
    let (moved, jacobians) = integration.step_with_jacobians(pose, twist, dt);
    let (f_x, f_u) = (jacobians.by_pose, jacobians.by_twist);
    let covariance = f_x * belief.covariance * f_x.transpose()
        + f_u * noise.covariance(twist, dt) * f_u.transpose();
    Gaussian { mean: moved.to_vector(), covariance: 0.5 * (covariance + covariance.transpose()) }
}
// ANCHOR_END: dead-reckon
