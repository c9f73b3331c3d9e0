//! Simulated drives that look like what figures are made for.

use loc_core::motion::{Integration, VelocityNoise, dead_reckon};
use loc_core::nalgebra::{Matrix2, Matrix2x3, Vector2, Vector3};
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Gaussian, Pose2, Twist2};

pub(super) const STEP: f64 = 0.1;

/// True poses, beliefs, and where measurements saw landmarks.
pub(super) struct Drive {
    pub(super) truth: Vec<Pose2>,
    pub(super) beliefs: Vec<Gaussian<3>>,
    pub(super) seen: Vec<(f64, f64)>,
}

pub(super) fn landmarks() -> Vec<((f64, f64), String)> {
    let places = [
        (0.5, 2.2),
        (3.0, -0.6),
        (5.2, 1.4),
        (4.8, 4.4),
        (2.0, 5.4),
        (-0.8, 4.2),
        (2.2, 2.6),
        (2.4, 2.5),
    ];
    let named = |(k, place): (usize, (f64, f64))| (place, format!("{}", k + 6));
    places.into_iter().enumerate().map(named).collect()
}

/// A circle of 140 steps; every `fix_every` steps the position is measured by a landmark.
pub(super) fn circle(fix_every: usize, seed: u64) -> Drive {
    let mut rng = stream(seed, "figures");
    let noise = VelocityNoise::from_sigmas(0.05, 0.6, 0.06).unwrap();
    let twist = Twist2::forward(1.0, std::f64::consts::TAU / 14.0);
    let mut truth = vec![Pose2::new(2.0, 0.2, 0.0)];
    let mut beliefs = vec![Gaussian::certain(truth[0].to_vector())];
    let mut seen = Vec::new();
    for k in 1..=140 {
        let disturbed = disturb(twist, &noise, &mut rng);
        let pose = Integration::ExactArc.step(truth[k - 1], disturbed, STEP);
        let mut belief = dead_reckon(&beliefs[k - 1], twist, STEP, Integration::ExactArc, &noise);
        if fix_every > 0 && k % fix_every == 0 {
            belief = fix(&belief, pose, &mut rng, &mut seen);
        }
        truth.push(pose);
        beliefs.push(belief);
    }
    Drive { truth, beliefs, seen }
}

fn disturb(twist: Twist2, noise: &VelocityNoise, rng: &mut ChaCha8Rng) -> Twist2 {
    let wanted = Gaussian::new(twist.to_vector(), noise.covariance(twist, STEP)).unwrap();
    Twist2::from_vector(&wanted.sample(rng))
}

/// A Kalman correction by the position that a landmark's observation amounts to.
fn fix(
    belief: &Gaussian<3>,
    pose: Pose2,
    rng: &mut ChaCha8Rng,
    seen: &mut Vec<(f64, f64)>,
) -> Gaussian<3> {
    let h = Matrix2x3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
    let r = Matrix2::identity() * 0.15f64.powi(2);
    let measured = Gaussian::new(Vector2::new(pose.x, pose.y), r).unwrap().sample(rng);
    let s = h * belief.covariance * h.transpose() + r;
    let gain = belief.covariance * h.transpose() * s.try_inverse().unwrap();
    let mean: Vector3<f64> = belief.mean + gain * (measured - h * belief.mean);
    let covariance = belief.covariance - gain * s * gain.transpose();
    let nearest = landmarks().into_iter().map(|(place, _)| place).min_by(|a, b| {
        let far = |p: &(f64, f64)| f64::hypot(p.0 - pose.x, p.1 - pose.y);
        far(a).total_cmp(&far(b))
    });
    let (x, y) = nearest.unwrap();
    seen.push((x + mean.x - pose.x, y + mean.y - pose.y));
    let covariance = 0.5 * (covariance + covariance.transpose());
    Gaussian { mean, covariance }
}
