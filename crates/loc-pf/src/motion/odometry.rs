//! The odometry model (rot1, trans, rot2) of a differential drive.

use super::Motion;
use crate::PosesMut;
use loc_core::motion::{OdometryMotion, OdometryNoise};
use loc_core::random::ChaCha8Rng;

/// A step read from odometry, with the noise alpha1 to alpha4.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DifferentialStep {
    /// The step.
    pub motion: OdometryMotion,
    /// Its noise.
    pub noise: OdometryNoise,
}

impl Motion for DifferentialStep {
    fn sample(&self, poses: PosesMut<'_>, rng: &mut ChaCha8Rng) {
        for ((x, y), theta) in poses.x.iter_mut().zip(poses.y).zip(poses.theta) {
            let moved = self.motion.sample(&self.noise, rng).apply(loc_core::Pose2 {
                x: *x,
                y: *y,
                theta: *theta,
            });
            (*x, *y, *theta) = (moved.x, moved.y, moved.theta);
        }
    }
}
