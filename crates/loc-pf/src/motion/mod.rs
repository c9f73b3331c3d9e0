//! Motion models: where a robot may be after a step, drawn for each of many poses (M4).

mod driven;
mod odometry;

pub use driven::{DrivenPath, NoisyStep, PathNoise};
pub use odometry::DifferentialStep;

use crate::PosesMut;
use loc_core::Pose2;
use loc_core::random::ChaCha8Rng;

/// A step of the robot with its noise, ready to move particles.
///
/// Several threads move different particles at the same time, each with a generator of its own.
pub trait Motion: Sync {
    /// Moves each pose by a step drawn from the noise. Headings stay in (-pi, pi].
    fn sample(&self, poses: PosesMut<'_>, rng: &mut ChaCha8Rng);
}

/// A motion as a function of the pose before and of standard normal numbers.
///
/// Whoever knows the numbers behind a particle can change them a little and place the particle
/// anew, without leaving what the motion allows: see [`Tempering`](crate::Tempering).
pub trait Transport: Sync {
    /// The pose that `noise`, four independent standard normal numbers, leads to from `pose`.
    fn moved(&self, pose: Pose2, noise: [f64; 4]) -> Pose2;
}
