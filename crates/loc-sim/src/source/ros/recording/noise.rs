//! Noise on top of a recorded odometry.

use loc_core::motion::VelocityNoise;
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Pose2, angle};
use rand_distr::{Distribution, StandardNormal};

/// An odometry that drifts away from the recorded one (E7): each step gets errors of distance and
/// heading whose variances grow with the way and the turn.
#[derive(Debug)]
pub(super) struct NoisyOdometry {
    noise: VelocityNoise,
    rng: ChaCha8Rng,
    /// The last pose as recorded, and with its noise.
    last: Option<(Pose2, Pose2)>,
}

impl NoisyOdometry {
    pub(super) fn new(noise: VelocityNoise, seed: u64) -> Self {
        NoisyOdometry { noise, rng: stream(seed, "odometry"), last: None }
    }

    /// The noisy pose in place of the next recorded one.
    pub(super) fn next(&mut self, recorded: Pose2) -> Pose2 {
        let noisy = match self.last {
            None => recorded,
            Some((before, noisy)) => noisy * self.disturbed(before.between(recorded)),
        };
        self.last = Some((recorded, noisy));
        noisy
    }

    /// A step with an error along the way, and one of the heading of which half has happened when
    /// half of the way is done.
    fn disturbed(&mut self, step: Pose2) -> Pose2 {
        let (way, turn) = (step.x.hypot(step.y), step.theta.abs());
        let mut normal = |variance: f64| {
            let unit: f64 = StandardNormal.sample(&mut self.rng);
            variance.sqrt() * unit
        };
        let along = normal(self.noise.k_d * way);
        let heading = normal(self.noise.k_theta * turn + self.noise.k_drift * way);
        let scale = if way > 0.0 { 1.0 + along / way } else { 1.0 };
        let (sin, cos) = (heading / 2.0).sin_cos();
        Pose2::new(
            scale * (cos * step.x - sin * step.y),
            scale * (sin * step.x + cos * step.y),
            angle::wrap(step.theta + heading),
        )
    }
}
