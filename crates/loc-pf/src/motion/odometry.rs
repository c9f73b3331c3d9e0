//! The odometry models of nav2_amcl: (rot1, trans, rot2) of a differential drive, and that of an
//! omnidirectional drive.

use super::{
    Displacement, Motion, Step, Transport, angle_sigma, bounded, move_all, moved, way_sigma,
};
use crate::{PosesMut, Result};
use loc_core::Pose2;
use loc_core::error::non_negative;
use loc_core::motion::{OdometryMotion, OdometryNoise};
use loc_core::random::ChaCha8Rng;

/// A step read from odometry as turn, drive, turn, with the noise alpha1 to alpha4 (Probabilistic
/// Robotics, table 5.6).
///
/// Backward drives keep their small turns ([`OdometryMotion::between`]), and so their small noise.
/// When a robot turns on the spot, the direction of the few millimetres that it moves is random,
/// and the textbook takes it for a large turn forth and back. Here, of `rot1`, the share
/// `d^2 / (d^2 + d0^2)` counts as a separate turn, with the distance `d` and `d0` =
/// [`SHORT_DRIVE`](DifferentialStep::SHORT_DRIVE); the rest of the whole turn counts as `rot2`. The
/// step itself is not changed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DifferentialStep {
    motion: OdometryMotion,
    /// Standard deviations of (rot1, trans, rot2).
    sigmas: [f64; 3],
}

impl DifferentialStep {
    /// Distance \[m\] at which half of `rot1` counts as a separate turn.
    pub const SHORT_DRIVE: f64 = 0.01;

    /// A step with its noise.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a step that is not finite or beyond 1e9 m, and for noise
    /// that is negative or not finite.
    pub fn new(motion: OdometryMotion, noise: &OdometryNoise) -> Result<Self> {
        bounded("rot1 [rad]", motion.rot1)?;
        bounded("trans [m]", motion.trans)?;
        bounded("rot2 [rad]", motion.rot2)?;
        let OdometryNoise { alpha1, alpha2, alpha3, alpha4 } = *noise;
        let names = ["alpha1", "alpha2 [rad^2/m^2]", "alpha3", "alpha4 [m^2/rad^2]"];
        for (name, alpha) in names.into_iter().zip([alpha1, alpha2, alpha3, alpha4]) {
            non_negative(name, alpha)?;
        }
        let squares = [motion.trans, Self::SHORT_DRIVE].map(|way| way * way);
        let deliberate = squares[0] / (squares[0] + squares[1]);
        let rot1 = deliberate * motion.rot1;
        let turns = OdometryMotion { rot1, rot2: motion.rot1 + motion.rot2 - rot1, ..motion };
        let variances = turns.variances(noise);
        let sigmas = [angle_sigma(variances.x), way_sigma(variances.y), angle_sigma(variances.z)];
        Ok(DifferentialStep { motion, sigmas })
    }

    /// The step from one pose of the odometry to the next.
    ///
    /// # Errors
    /// As [`new`](DifferentialStep::new).
    pub fn between(from: Pose2, to: Pose2, noise: &OdometryNoise) -> Result<Self> {
        DifferentialStep::new(OdometryMotion::between(from, to), noise)
    }

    /// The step without noise.
    pub fn motion(&self) -> OdometryMotion {
        self.motion
    }

    /// Standard deviations of (rot1, trans, rot2) \[rad, m, rad\].
    pub fn sigmas(&self) -> [f64; 3] {
        self.sigmas
    }
}

impl Step for DifferentialStep {
    #[inline(always)]
    fn draw(self, noise: [f64; 3]) -> Displacement {
        let rot1 = self.motion.rot1 + self.sigmas[0] * noise[0];
        let rot2 = self.motion.rot2 + self.sigmas[2] * noise[2];
        let along = self.motion.trans + self.sigmas[1] * noise[1];
        Displacement { direction: rot1, along, across: 0.0, turn: rot1 + rot2 }
    }
}

impl Motion for DifferentialStep {
    fn sample(&self, poses: PosesMut<'_>, rng: &mut ChaCha8Rng) {
        move_all(*self, poses, rng);
    }
}

impl Transport for DifferentialStep {
    /// The first three numbers are the noise, in the order of [`sigmas`](DifferentialStep::sigmas).
    fn moved(&self, pose: Pose2, noise: [f64; 4]) -> Pose2 {
        moved(*self, pose, noise)
    }
}

/// Noise of a drive that moves in any direction, with the meaning and the names of nav2_amcl's
/// `OmniMotionModel`: variances of a step that goes `d` \[m\] and turns by `a` \[rad\].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct OmnidirectionalNoise {
    /// Turn variance per squared turn \[-\].
    pub alpha1: f64,
    /// Turn variance per squared distance \[rad^2/m^2\].
    pub alpha2: f64,
    /// Variance along the path, per squared distance \[-\].
    pub alpha3: f64,
    /// Variance along and across the path, per squared turn \[m^2/rad^2\].
    pub alpha4: f64,
    /// Variance across the path, per squared distance \[-\].
    pub alpha5: f64,
}

impl Default for OmnidirectionalNoise {
    /// nav2_amcl's: 0.2 each.
    fn default() -> Self {
        OmnidirectionalNoise { alpha1: 0.2, alpha2: 0.2, alpha3: 0.2, alpha4: 0.2, alpha5: 0.2 }
    }
}

impl OmnidirectionalNoise {
    /// Checks every value.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for negative values, NaN and infinity.
    pub fn check(&self) -> loc_core::Result<()> {
        non_negative("alpha1", self.alpha1)?;
        non_negative("alpha2 [rad^2/m^2]", self.alpha2)?;
        non_negative("alpha3", self.alpha3)?;
        non_negative("alpha4 [m^2/rad^2]", self.alpha4)?;
        non_negative("alpha5", self.alpha5)?;
        Ok(())
    }
}

/// A step in any direction, read from odometry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OmnidirectionalStep {
    /// Displacement in the robot's frame \[m\] and turn \[rad\].
    step: Pose2,
    /// Cosine and sine of the direction of travel, against the heading.
    direction: [f64; 2],
    /// Standard deviations along the path, across it, and of the turn.
    sigmas: [f64; 3],
}

impl OmnidirectionalStep {
    /// The step from one pose of the odometry to the next.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for poses that are not finite or 1e9 m apart, and for noise
    /// that is negative or not finite.
    pub fn between(from: Pose2, to: Pose2, noise: &OmnidirectionalNoise) -> Result<Self> {
        noise.check()?;
        let step = from.between(to);
        let way = bounded("way between two odometry poses [m]", f64::hypot(step.x, step.y))?;
        let turn = bounded("turn between two odometry poses [rad]", step.theta)?;
        let direction = if way > 0.0 { [step.x / way, step.y / way] } else { [1.0, 0.0] };
        let variance = |per_way: f64, per_turn: f64| per_way * way * way + per_turn * turn * turn;
        let sigmas = [
            way_sigma(variance(noise.alpha3, noise.alpha4)),
            way_sigma(variance(noise.alpha5, noise.alpha4)),
            angle_sigma(variance(noise.alpha2, noise.alpha1)),
        ];
        Ok(OmnidirectionalStep { step, direction, sigmas })
    }

    /// Standard deviations along the path, across it, and of the turn \[m, m, rad\].
    pub fn sigmas(&self) -> [f64; 3] {
        self.sigmas
    }
}

impl Step for OmnidirectionalStep {
    #[inline(always)]
    fn draw(self, noise: [f64; 3]) -> Displacement {
        let (along, across) = (self.sigmas[0] * noise[0], self.sigmas[1] * noise[1]);
        let [cos, sin] = self.direction;
        Displacement {
            direction: 0.0,
            along: self.step.x + (along * cos - across * sin),
            across: self.step.y + (along * sin + across * cos),
            turn: self.step.theta + self.sigmas[2] * noise[2],
        }
    }
}

impl Motion for OmnidirectionalStep {
    fn sample(&self, poses: PosesMut<'_>, rng: &mut ChaCha8Rng) {
        move_all(*self, poses, rng);
    }
}

impl Transport for OmnidirectionalStep {
    /// The first three numbers are the noise, in the order of
    /// [`sigmas`](OmnidirectionalStep::sigmas).
    fn moved(&self, pose: Pose2, noise: [f64; 4]) -> Pose2 {
        moved(*self, pose, noise)
    }
}
