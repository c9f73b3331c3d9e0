//! Motion models: where a robot may be after a step, drawn for each of many poses (M4).
//!
//! A robot never moves quite as it was told, or as its wheels say. A motion model draws for every
//! particle one step that may have been: the step that was measured plus noise, carried out from
//! the particle's pose. Each model here is computed once per step and then moves many poses at
//! once: [`DifferentialStep`] and [`OmnidirectionalStep`] from two poses of the odometry,
//! [`VelocityStep`] from a velocity, [`AckermannStep`] from speed and steering angle. A closure
//! from pose to pose is a motion model too.
//!
//! Without noise every pose moves exactly by the step. Noise is single precision
//! ([`crate::normals`]), poses are double; the results are the same on every machine and for any
//! number of threads.
//!
//! ```
//! use loc_core::{Pose2, motion::OdometryNoise, random::stream};
//! use loc_pf::motion::{DifferentialStep, Motion};
//! use loc_pf::Particles;
//! let noise = OdometryNoise { alpha1: 0.1, alpha2: 0.1, alpha3: 0.1, alpha4: 0.1 };
//! let (before, now) = (Pose2::new(2.0, 1.0, 0.0), Pose2::new(3.0, 1.0, 0.0));
//! let step = DifferentialStep::between(before, now, &noise)?;
//! let mut cloud = Particles::from_poses(vec![Pose2::IDENTITY; 1000]);
//! step.sample(cloud.poses_mut(), &mut stream(1, "motion"));
//! let mean = cloud.poses().x.iter().sum::<f64>() / 1000.0;
//! assert!((mean - 0.95).abs() < 0.05);
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod ackermann;
mod differential;
mod driven;
mod omnidirectional;
mod step;
mod velocity;

pub use ackermann::AckermannStep;
pub use differential::DifferentialStep;
pub use driven::NoisyStep;
pub use loc_core::motion::{DrivenPath, PathNoise};
pub use omnidirectional::{OmnidirectionalNoise, OmnidirectionalStep};
pub use velocity::VelocityStep;

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

/// Moves one pose at a time.
impl<F: Fn(Pose2, &mut ChaCha8Rng) -> Pose2 + Sync> Motion for F {
    fn sample(&self, poses: PosesMut<'_>, rng: &mut ChaCha8Rng) {
        for ((x, y), theta) in poses.x.iter_mut().zip(poses.y).zip(poses.theta) {
            let moved = self(Pose2 { x: *x, y: *y, theta: *theta }, rng);
            (*x, *y, *theta) = (moved.x, moved.y, loc_core::angle::wrap(moved.theta));
        }
    }
}
