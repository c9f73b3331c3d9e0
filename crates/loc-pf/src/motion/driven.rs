//! What a robot has driven since the last update, and how far its odometry may be off by then.
//!
//! Errors of odometry grow with the way driven and the turning done, not with the square of their
//! sum: variances add up along the way, so that it makes no difference into how many updates a
//! drive is cut (E7). Now and then a wheel spins, the robot is stuck or pushed, or its encoders
//! count the wrong way, and odometry is wrong by as much as it reports. A small share of the
//! particles takes that into account at every step; without them such a moment loses the robot.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_pf::motion::{DrivenPath, NoisyStep, PathNoise, Transport};
//! let mut path = DrivenPath::starting_at(Pose2::IDENTITY);
//! path.extend(Pose2::new(1.0, 0.0, 0.0));
//! path.extend(Pose2::new(0.5, 0.0, 0.0));
//! assert_eq!((path.length(), path.step().x), (1.5, 0.5));
//! let step = NoisyStep::new(&path, &PathNoise::default());
//! assert_eq!(step.moved(Pose2::IDENTITY, [0.0; 4]), Pose2::new(0.5, 0.0, 0.0));
//! ```

use super::{Motion, Transport};
use crate::PosesMut;
use crate::Result;
use crate::normals::Normals;
use loc_core::error::{non_negative, probability};
use loc_core::random::ChaCha8Rng;
use loc_core::{Gaussian, Normal, Pose2};
use nalgebra::{Matrix3, Vector3};

/// A way through the odometry's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DrivenPath {
    from: Pose2,
    to: Pose2,
    length: f64,
    turned: f64,
}

/// How far odometry may be off after a way; variances in proportion to length and turning.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct PathNoise {
    /// Standard deviation along the way after 1 m \[m\]; `sqrt(k_d)` of E7.
    pub along: f64,
    /// Standard deviation across the way after 1 m \[m\].
    pub across: f64,
    /// Standard deviation of the heading after 1 m \[rad\]; `sqrt(k_drift)` of E7.
    pub drift: f64,
    /// Standard deviation of the heading after turning by 1 rad \[rad\]; `sqrt(k_theta)` of E7.
    pub turn: f64,
    /// Standard deviation of the position after turning by 1 rad \[m\]: the point that odometry
    /// tracks is not quite the one it turns about.
    pub pivot: f64,
    /// Probability that odometry fails in a step: slip, a push, a wrong count.
    pub fault_probability: f64,
}

impl Default for PathNoise {
    fn default() -> Self {
        PathNoise {
            along: 0.05,
            across: 0.03,
            drift: 3_f64.to_radians(),
            turn: 5_f64.to_radians(),
            pivot: 0.05,
            fault_probability: 0.1,
        }
    }
}

impl PathNoise {
    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] naming the first that is not allowed.
    pub fn validate(&self) -> Result<()> {
        non_negative("noise along the way [m]", self.along)?;
        non_negative("noise across the way [m]", self.across)?;
        non_negative("drift of the heading [rad]", self.drift)?;
        non_negative("noise of turning [rad]", self.turn)?;
        non_negative("noise of the pivot [m]", self.pivot)?;
        probability("probability of an odometry fault", self.fault_probability)?;
        Ok(())
    }
}

impl DrivenPath {
    /// A way that has not begun, at a pose of the odometry's frame.
    pub fn starting_at(pose: Pose2) -> Self {
        DrivenPath { from: pose, to: pose, length: 0.0, turned: 0.0 }
    }

    /// Drives on to the next pose that odometry reports.
    pub fn extend(&mut self, to: Pose2) {
        let step = self.to.between(to);
        self.length += f64::hypot(step.x, step.y);
        self.turned += step.theta.abs();
        self.to = to;
    }

    /// Where it began, in the odometry's frame.
    pub fn start(&self) -> Pose2 {
        self.from
    }

    /// Where it ends, in the odometry's frame.
    pub fn end(&self) -> Pose2 {
        self.to
    }

    /// The end as seen from the start.
    pub fn step(&self) -> Pose2 {
        self.from.between(self.to)
    }

    /// The length of the way, not of the straight line \[m\].
    pub fn length(&self) -> f64 {
        self.length
    }

    /// All turning on the way, whichever way round \[rad\].
    pub fn turned(&self) -> f64 {
        self.turned
    }
}

/// A step with its noise: from a pose and four standard normal numbers to the next pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoisyStep {
    step: Pose2,
    /// Standard deviations along, across, of the heading.
    sigmas: [f64; 3],
    faulty_sigmas: [f64; 3],
    /// Odometry has failed where the fourth number lies above this.
    fault_above: f64,
}

impl NoisyStep {
    /// The step of a driven path.
    pub fn new(path: &DrivenPath, noise: &PathNoise) -> Self {
        let pivot = noise.pivot.powi(2) * path.turned;
        let along = noise.along.powi(2) * path.length + pivot;
        let across = noise.across.powi(2) * path.length + pivot;
        let heading = noise.drift.powi(2) * path.length + noise.turn.powi(2) * path.turned;
        // A failed odometry is off by about what it reports.
        let faulty_along = along + path.length.powi(2);
        let faulty_across = across + (0.3 * path.length).powi(2);
        let faulty_heading = heading + (0.3 * path.turned + 0.1 * path.length).powi(2);
        let quantile = Normal::STANDARD.quantile(1.0 - noise.fault_probability);
        NoisyStep {
            step: path.step(),
            sigmas: [along, across, heading].map(f64::sqrt),
            faulty_sigmas: [faulty_along, faulty_across, faulty_heading].map(f64::sqrt),
            fault_above: quantile.unwrap_or(f64::INFINITY),
        }
    }

    /// A belief carried along by the step to first order (E6), faults of the odometry left aside.
    pub fn belief_after(&self, belief: &Gaussian<3>) -> Gaussian<3> {
        let pose = belief.pose();
        let after = pose * self.step;
        let (dx, dy) = (after.x - pose.x, after.y - pose.y);
        let (sin, cos) = pose.theta.sin_cos();
        let by_pose = Matrix3::new(1.0, 0.0, -dy, 0.0, 1.0, dx, 0.0, 0.0, 1.0);
        let by_noise = Matrix3::new(cos, -sin, -0.5 * dy, sin, cos, 0.5 * dx, 0.0, 0.0, 1.0);
        let variances = Matrix3::from_diagonal(&Vector3::from(self.sigmas.map(|s| s * s)));
        let covariance = by_pose * belief.covariance * by_pose.transpose()
            + by_noise * variances * by_noise.transpose();
        Gaussian { mean: after.to_vector(), covariance }
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
