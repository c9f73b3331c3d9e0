//! The step of a driven path for particles.
//!
//! How far odometry may be off after a way is [`PathNoise`]'s business. Now and then a wheel spins,
//! the robot is stuck or pushed, or its encoders count the wrong way, and odometry is wrong by as
//! much as it reports. A small share of the particles takes that into account at every step;
//! without them such a moment loses the robot.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_pf::motion::{DrivenPath, NoisyStep, PathNoise, Transport};
//! let mut path = DrivenPath::starting_at(Pose2::IDENTITY);
//! path.extend(Pose2::new(1.0, 0.0, 0.0));
//! path.extend(Pose2::new(0.5, 0.0, 0.0));
//! let step = NoisyStep::new(&path, &PathNoise::default());
//! assert_eq!(step.moved(Pose2::IDENTITY, [0.0; 4]), Pose2::new(0.5, 0.0, 0.0));
//! ```

use super::{Motion, Transport};
use crate::PosesMut;
use crate::normals::Normals;
use loc_core::motion::{DrivenPath, PathNoise};
use loc_core::random::ChaCha8Rng;
use loc_core::{Normal, Pose2};

/// A step with its noise: from a pose and four standard normal numbers to the next pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoisyStep {
    step: Pose2,
    /// Standard deviations along, across and of the heading.
    sigmas: [f64; 3],
    faulty_sigmas: [f64; 3],
    /// Odometry has failed where the fourth number lies above this.
    fault_above: f64,
}

impl NoisyStep {
    /// The step of a driven path.
    pub fn new(path: &DrivenPath, noise: &PathNoise) -> Self {
        let variances = noise.variances(path);
        let least = [noise.min_position, noise.min_position, noise.min_heading];
        let sigma = |k: usize, more: f64| (variances[k] + least[k].powi(2) + more.powi(2)).sqrt();
        let fault = PathNoise::fault_sigmas(path);
        let quantile = Normal::STANDARD.quantile(1.0 - noise.fault_probability);
        NoisyStep {
            step: path.step(),
            sigmas: [sigma(0, 0.0), sigma(1, 0.0), sigma(2, 0.0)],
            faulty_sigmas: [sigma(0, fault.x), sigma(1, fault.y), sigma(2, fault.z)],
            fault_above: quantile.unwrap_or(f64::INFINITY),
        }
    }
}

impl Transport for NoisyStep {
    /// The four numbers stand for the noise along, across, of the heading, and for whether odometry
    /// failed.
    fn moved(&self, pose: Pose2, noise: [f64; 4]) -> Pose2 {
        let failed = noise[3] > self.fault_above;
        let sigmas = if failed { self.faulty_sigmas } else { self.sigmas };
        let turn = sigmas[2] * noise[2];
        // On the average over the way the heading is off by half of what it is off at the end.
        let (sin, cos) = (0.5 * turn).sin_cos();
        let along = self.step.x + sigmas[0] * noise[0];
        let across = self.step.y + sigmas[1] * noise[1];
        let step = Pose2::new(
            cos * along - sin * across,
            sin * along + cos * across,
            self.step.theta + turn,
        );
        pose * step
    }
}

impl Motion for NoisyStep {
    fn sample(&self, poses: PosesMut<'_>, rng: &mut ChaCha8Rng) {
        let mut normals = Normals::from_rng(rng);
        let mut noise = [[0.0_f32; 4]; 16];
        let blocks = poses.x.chunks_mut(16).zip(poses.y.chunks_mut(16));
        for ((x, y), theta) in blocks.zip(poses.theta.chunks_mut(16)) {
            normals.fill(noise.as_flattened_mut());
            for (((x, y), theta), noise) in x.iter_mut().zip(y).zip(theta).zip(&noise) {
                let pose = Pose2 { x: *x, y: *y, theta: *theta };
                let moved = self.moved(pose, noise.map(f64::from));
                (*x, *y, *theta) = (moved.x, moved.y, moved.theta);
            }
        }
    }
}
