//! Motion models: where a robot may be after a step, drawn for each of many poses (M4).

mod odometry;

pub use odometry::DifferentialStep;

use crate::PosesMut;
use loc_core::random::ChaCha8Rng;

/// A step of the robot with its noise, ready to move particles.
///
/// Several threads move different particles at the same time, each with a generator of its own.
pub trait Motion: Sync {
    /// Moves each pose by a step drawn from the noise. Headings stay in (-pi, pi].
    fn sample(&self, poses: PosesMut<'_>, rng: &mut ChaCha8Rng);
}
