//! Motion from the poses that odometry reports: the odometry motion model (rotation, translation,
//! rotation; Probabilistic Robotics, 5.4), and the path driven with its noise (E6, E7).
//!
//! Variances of odometry grow with the distance driven and the angle turned, not with their
//! squares: they add up along the path, so the number of steps that a path is cut into makes no
//! difference (E7). [`PathNoise`] propagates a belief along a [`DrivenPath`] to first order (E6).
//!
//! ```
//! use loc_core::motion::{DrivenPath, PathNoise};
//! use loc_core::{Gaussian, Pose2};
//! let mut path = DrivenPath::starting_at(Pose2::IDENTITY);
//! path.extend(Pose2::new(1.0, 0.0, 0.0));
//! path.extend(Pose2::new(0.5, 0.0, 0.0));
//! assert_eq!((path.length(), path.step().x), (1.5, 0.5));
//! let start = Gaussian::certain(Pose2::IDENTITY.to_vector());
//! let after = PathNoise::default().belief_after(&path, &start);
//! assert_eq!(after.pose(), Pose2::new(0.5, 0.0, 0.0));
//! assert!((after.covariance.m11 - 1.5 * 0.05_f64.powi(2)).abs() < 1e-12);
//! ```

use crate::{Gaussian, Pose2, angle};
use nalgebra::{Matrix3, Vector3};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// A step of the robot, read from two poses of its odometry.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OdometryMotion {
    /// First turn, towards the direction of travel \[rad\]; also known as delta_rot1.
    pub rot1: f64,
    /// Distance driven, negative backwards \[m\]; also known as delta_trans.
    pub trans: f64,
    /// Second turn, to the final heading \[rad\]; also known as delta_rot2.
    pub rot2: f64,
}

/// Noise of the odometry model.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OdometryNoise {
    /// Turn variance per squared turn \[-\].
    pub alpha1: f64,
    /// Turn variance per squared distance \[rad^2/m^2\].
    pub alpha2: f64,
    /// Distance variance per squared distance \[-\].
    pub alpha3: f64,
    /// Distance variance per squared turn \[m^2/rad^2\].
    pub alpha4: f64,
}

impl OdometryMotion {
    /// Below this distance \[m\] the direction of travel is only noise, and the whole rotation is
    /// `rot2`.
    pub const MIN_TRANSLATION: f64 = 1e-6;

    /// The step that leads from one odometry pose to the next.
    ///
    /// A drive backwards keeps its small turns and gets a negative distance.
    // ANCHOR: odometry-step
    pub fn between(from: Pose2, to: Pose2) -> Self {
        let step = from.between(to);
        let distance = f64::hypot(step.x, step.y);
        if distance < Self::MIN_TRANSLATION {
            // The part along the heading, with its sign: the jitter of a robot that stands still
            // must not add up to a drive forward.
            return OdometryMotion { rot1: 0.0, trans: step.x, rot2: step.theta };
        }
        let direction = step.y.atan2(step.x);
        let backwards = direction.abs() > std::f64::consts::FRAC_PI_2;
        let (rot1, trans) = if backwards {
            (angle::wrap(direction + std::f64::consts::PI), -distance)
        } else {
            (direction, distance)
        };
        OdometryMotion { rot1, trans, rot2: angle::difference(step.theta, rot1) }
    }
    // ANCHOR_END: odometry-step

    /// The pose after this step from `pose`.
    pub fn apply(self, pose: Pose2) -> Pose2 {
        let direction = pose.theta + self.rot1;
        Pose2::new(
            pose.x + self.trans * direction.cos(),
            pose.y + self.trans * direction.sin(),
            direction + self.rot2,
        )
    }

    /// [`apply`](OdometryMotion::apply) with its derivatives over the pose and over
    /// (rot1, trans, rot2), 3 x 3 each.
    pub fn apply_with_jacobians(self, pose: Pose2) -> (Pose2, Matrix3<f64>, Matrix3<f64>) {
        let (sin, cos) = (pose.theta + self.rot1).sin_cos();
        let (dx, dy) = (self.trans * cos, self.trans * sin);
        let by_pose = Matrix3::new(1.0, 0.0, -dy, 0.0, 1.0, dx, 0.0, 0.0, 1.0);
        let by_step = Matrix3::new(-dy, cos, 0.0, dx, sin, 0.0, 1.0, 0.0, 1.0);
        (self.apply(pose), by_pose, by_step)
    }

    /// Variances of (rot1, trans, rot2) under the given noise.
    // ANCHOR: odometry-noise
    pub fn variances(self, noise: &OdometryNoise) -> Vector3<f64> {
        let [r1, t, r2] = [self.rot1, self.trans, self.rot2].map(|v| v * v);
        Vector3::new(
            noise.alpha1 * r1 + noise.alpha2 * t,
            noise.alpha3 * t + noise.alpha4 * (r1 + r2),
            noise.alpha1 * r2 + noise.alpha2 * t,
        )
    }
    // ANCHOR_END: odometry-noise

    /// A step drawn from the noise around this one.
    pub fn sample<R: Rng + ?Sized>(self, noise: &OdometryNoise, rng: &mut R) -> Self {
        let variances = self.variances(noise);
        let mut draw = |variance: f64| {
            let z: f64 = StandardNormal.sample(rng);
            variance.sqrt() * z
        };
        OdometryMotion {
            rot1: angle::wrap(self.rot1 + draw(variances.x)),
            trans: self.trans + draw(variances.y),
            rot2: angle::wrap(self.rot2 + draw(variances.z)),
        }
    }
}

/// A path in the odometry's frame: its first and last pose, its length and its turning.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DrivenPath {
    from: Pose2,
    to: Pose2,
    length: f64,
    turned: f64,
}

crate::settings! {
    /// Noise of odometry over a path; variances in proportion to length and turning.
    #[derive(Copy)]
    pub struct PathNoise {
        /// Standard deviation along the path after 1 m \[m\]; `sqrt(k_d)` of E7.
        pub along: f64 = 0.05 => non_negative;
        /// Standard deviation across the path after 1 m \[m\].
        pub across: f64 = 0.03 => non_negative;
        /// Standard deviation of the heading after 1 m \[rad\]; `sqrt(k_drift)` of E7.
        #[serde(with = "crate::settings::angle")]
        pub drift: f64 = 3_f64.to_radians() => non_negative;
        /// Standard deviation of the heading after turning by 1 rad \[rad\]; `sqrt(k_theta)` of E7.
        #[serde(with = "crate::settings::angle")]
        pub turn: f64 = 5_f64.to_radians() => non_negative;
        /// Standard deviation of the position after turning by 1 rad \[m\]: the point that odometry
        /// tracks is not quite the one it turns about.
        pub pivot: f64 = 0.05 => non_negative;
        /// Lower bound of the standard deviation of the position of every update, however short its
        /// path \[m\]: it keeps particles apart and filters from becoming overconfident.
        pub min_position: f64 = 0.005 => non_negative;
        /// Lower bound of the standard deviation of the heading of every update \[rad\].
        #[serde(with = "crate::settings::angle")]
        pub min_heading: f64 = 0.2_f64.to_radians() => non_negative;
        /// Probability that odometry fails in a step: slip, a push, a wrong count.
        pub fault_probability: f64 = 0.1 => probability;
    }
}

impl PathNoise {
    /// Variances that a path adds along it \[m^2\], across it \[m^2\] and to the heading \[rad^2\],
    /// without faults of the odometry and without the lower bounds.
    pub fn variances(&self, path: &DrivenPath) -> Vector3<f64> {
        let pivot = self.pivot.powi(2) * path.turned;
        Vector3::new(
            self.along.powi(2) * path.length + pivot,
            self.across.powi(2) * path.length + pivot,
            self.drift.powi(2) * path.length + self.turn.powi(2) * path.turned,
        )
    }

    /// Standard deviations along a path \[m\], across it \[m\] and of the heading \[rad\] where
    /// odometry has failed: its error is then about as large as the motion that it reports.
    pub fn fault_sigmas(path: &DrivenPath) -> Vector3<f64> {
        let (length, turned) = (path.length, path.turned);
        Vector3::new(length, 0.3 * length, 0.3 * turned + 0.1 * length)
    }

    /// A step along a path from `pose`, with `variances` along it, across it and of the heading.
    ///
    /// Averaged over the path, the error of the heading is half of its error at the end.
    pub fn step(path: &DrivenPath, pose: Pose2, variances: &Vector3<f64>) -> LinearizedStep {
        let after = pose * path.step();
        let (dx, dy) = (after.x - pose.x, after.y - pose.y);
        let (sin, cos) = pose.theta.sin_cos();
        let by_pose = Matrix3::new(1.0, 0.0, -dy, 0.0, 1.0, dx, 0.0, 0.0, 1.0);
        let by_noise = Matrix3::new(cos, -sin, -0.5 * dy, sin, cos, 0.5 * dx, 0.0, 0.0, 1.0);
        let noise = by_noise * Matrix3::from_diagonal(variances) * by_noise.transpose();
        LinearizedStep { pose: after, by_pose, noise }
    }

    /// A belief propagated along a path to first order (E6), without faults of the odometry and
    /// without the lower bounds.
    pub fn belief_after(&self, path: &DrivenPath, belief: &Gaussian<3>) -> Gaussian<3> {
        let LinearizedStep { pose, by_pose, noise } =
            PathNoise::step(path, belief.pose(), &self.variances(path));
        let covariance = by_pose * belief.covariance * by_pose.transpose() + noise;
        Gaussian { mean: pose.to_vector(), covariance }
    }
}

impl DrivenPath {
    /// An empty path, at a pose of the odometry's frame.
    pub fn starting_at(pose: Pose2) -> Self {
        DrivenPath { from: pose, to: pose, length: 0.0, turned: 0.0 }
    }

    /// Extends the path to the next pose that odometry reports.
    pub fn extend(&mut self, to: Pose2) {
        let step = self.to.between(to);
        self.length += f64::hypot(step.x, step.y);
        self.turned += step.theta.abs();
        self.to = to;
    }

    /// The pose at the start, in the odometry's frame.
    pub fn start(&self) -> Pose2 {
        self.from
    }

    /// The pose at the end, in the odometry's frame.
    pub fn end(&self) -> Pose2 {
        self.to
    }

    /// The end as seen from the start.
    pub fn step(&self) -> Pose2 {
        self.from.between(self.to)
    }

    /// The length of the path, not of the straight line \[m\].
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The sum of all turning, in both directions \[rad\].
    pub fn turned(&self) -> f64 {
        self.turned
    }
}

/// A step along a [`DrivenPath`], linearised at the pose where it starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearizedStep {
    /// The pose that it leads to.
    pub pose: Pose2,
    /// Its derivative over the pose before, 3 x 3.
    pub by_pose: Matrix3<f64>,
    /// The covariance that it adds over (x, y, theta) \[m, m, rad\], 3 x 3.
    pub noise: Matrix3<f64>,
}
