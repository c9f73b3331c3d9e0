//! Motion models: where a robot may be after a step, drawn for each of many poses (M4).
//!
//! A robot does not move exactly as commanded or as its odometry measures. A motion model draws for
//! every particle one possible step: the measured step plus noise, applied to the particle's pose.
//! Each model here is computed once per step and then moves many poses at once:
//! [`DifferentialStep`] and [`OmnidirectionalStep`] from two poses of the odometry,
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
//! let mut particles = Particles::from_poses(vec![Pose2::IDENTITY; 1000]);
//! step.sample(particles.poses_mut(), &mut stream(1, "motion"));
//! let mean = particles.poses().x.iter().sum::<f64>() / 1000.0;
//! assert!((mean - 0.95).abs() < 0.05);
//! # Ok::<(), loc_pf::Error>(())
//! ```
//!
//! [`NoisyStep`] is the step of a driven path. [`PathNoise`] gives the error of odometry along a path.
//! Occasionally a wheel slips, the robot is stuck or pushed, or an encoder counts in the wrong
//! direction, and the error of odometry is as large as the reported step. At every step a small
//! share of the particles is drawn with such an error; without them the robot would then be lost.
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

mod odometry;
mod velocity;

pub use loc_core::motion::{DrivenPath, PathNoise};
pub use odometry::{DifferentialStep, OmnidirectionalNoise, OmnidirectionalStep};
pub use velocity::{AckermannStep, VelocityStep};

use crate::elementary::{sin_cos, wrap};
use crate::normals::{BLOCK, Normals};
use crate::{PosesMut, Result};
use loc_core::error::in_range;
use loc_core::random::ChaCha8Rng;
use loc_core::{Normal, Pose2};
use pulp::{Arch, Simd, WithSimd};

/// A step of the robot with its noise, ready to move particles.
///
/// Several threads move different particles at the same time, each with a generator of its own.
pub trait Motion: Sync {
    /// Moves each pose by a step drawn from the noise. Headings stay in (-pi, pi].
    fn sample(&self, poses: PosesMut<'_>, rng: &mut ChaCha8Rng);
}

/// A motion as a function of the pose before and of standard normal numbers.
///
/// With the noise of a particle known, it can be changed a little and the particle moved again,
/// within the distribution of the motion: see [`Tempering`](crate::Tempering).
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

/// A step with its noise: from a pose and four standard normal numbers to the next pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoisyStep {
    step: Pose2,
    /// Standard deviations along, across and of the heading.
    sigmas: [f64; 3],
    faulty_sigmas: [f64; 3],
    /// Odometry has failed where the fourth number is above this.
    fault_above: f64,
}

impl NoisyStep {
    /// The step of a driven path.
    pub fn new(path: &DrivenPath, noise: &PathNoise) -> Self {
        let variances = noise.variances(path);
        let min = [noise.min_position, noise.min_position, noise.min_heading];
        let sigma = |k: usize, more: f64| (variances[k] + min[k].powi(2) + more.powi(2)).sqrt();
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
    /// The four numbers are the noise along, across, of the heading, and whether odometry failed.
    fn moved(&self, pose: Pose2, noise: [f64; 4]) -> Pose2 {
        let failed = noise[3] > self.fault_above;
        let sigmas = if failed { self.faulty_sigmas } else { self.sigmas };
        let turn = sigmas[2] * noise[2];
        // Averaged over the path, the error of the heading is half of that at its end.
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

/// A displacement in a frame that is turned against the robot's.
#[derive(Debug, Clone, Copy)]
struct Displacement {
    /// How far the frame is turned against the robot's heading before the step \[rad\].
    direction: f64,
    /// Distance in that direction \[m\].
    along: f64,
    /// Distance at a right angle to it, to the left \[m\].
    across: f64,
    /// Change of the heading \[rad\].
    turn: f64,
}

/// One drawn step, from three independent standard normal numbers.
///
/// Implementations are inlined into the vectorised loop and must not branch.
trait Step: Copy {
    fn draw(self, noise: [f64; 3]) -> Displacement;
}

/// One pose moved by the step with given noise.
fn moved<S: Step>(step: S, pose: Pose2, noise: [f64; 4]) -> Pose2 {
    let [first, second, third, _] = noise;
    let Displacement { direction, along, across, turn } = step.draw([first, second, third]);
    let (sin, cos) = (pose.theta + direction).sin_cos();
    Pose2::new(
        pose.x + along * cos - across * sin,
        pose.y + along * sin + across * cos,
        pose.theta + turn,
    )
}

/// Moves every pose by a drawn step.
fn move_all<S: Step>(step: S, poses: PosesMut<'_>, rng: &mut ChaCha8Rng) {
    let normals = Normals::from_rng(rng);
    Arch::new().dispatch(MoveAll { step, poses, normals });
}

struct MoveAll<'a, S> {
    step: S,
    poses: PosesMut<'a>,
    normals: Normals,
}

impl<S: Step> WithSimd for MoveAll<'_, S> {
    type Output = ();

    #[inline(always)]
    fn with_simd<V: Simd>(mut self, _: V) {
        let PosesMut { x, y, theta } = self.poses;
        let blocks = x.chunks_mut(BLOCK).zip(y.chunks_mut(BLOCK)).zip(theta.chunks_mut(BLOCK));
        for ((x, y), theta) in blocks {
            let noise = [self.normals.block(), self.normals.block(), self.normals.block()];
            move_block(self.step, [x, y, theta], &noise);
        }
    }
}

#[inline(always)]
fn move_block<S: Step>(step: S, [x, y, theta]: [&mut [f64]; 3], noise: &[[f32; BLOCK]; 3]) {
    let poses = x.iter_mut().zip(y).zip(theta);
    let noise = noise[0].iter().zip(&noise[1]).zip(&noise[2]);
    for (((x, y), theta), ((&a, &b), &c)) in poses.zip(noise) {
        let drawn = step.draw([f64::from(a), f64::from(b), f64::from(c)]);
        let (sin, cos) = sin_cos(*theta + drawn.direction);
        *x += drawn.along * cos - drawn.across * sin;
        *y += drawn.along * sin + drawn.across * cos;
        *theta = wrap(*theta + drawn.turn);
    }
}

/// A standard deviation of an angle, bounded: beyond a few turns every direction is as likely, and
/// larger angles would lose digits.
fn angle_sigma(variance: f64) -> f64 {
    variance.sqrt().min(1e3)
}

/// The standard deviation of a distance \[m\], bounded too: no coordinate overflows.
fn way_sigma(variance: f64) -> f64 {
    variance.sqrt().min(FURTHEST)
}

/// Checks that a distance \[m\] or a turn \[rad\] is possible for a robot.
fn bounded(what: &'static str, value: f64) -> Result<f64> {
    Ok(in_range(what, "a number in [-1e9, 1e9]", value, |value| value.abs() <= FURTHEST)?)
}

/// Maximum distance of a step \[m\].
const FURTHEST: f64 = 1e9;
