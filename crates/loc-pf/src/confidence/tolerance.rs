//! How far off a pose may be before it counts as lost.

use crate::{Particles, Result};
use loc_core::error::positive;
use loc_core::{Pose2, angle};

/// The largest error of a reported pose that is not yet called lost.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct Tolerance {
    /// Of the position \[m\].
    pub distance: f64,
    /// Of the heading \[rad\].
    pub turn: f64,
}

impl Default for Tolerance {
    /// 0.5 m and 15 degrees.
    fn default() -> Self {
        Tolerance { distance: 0.5, turn: 15_f64.to_radians() }
    }
}

impl Tolerance {
    /// Checks both numbers.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] naming the first that is not positive.
    pub fn validate(&self) -> Result<()> {
        positive("tolerance of the position [m]", self.distance)?;
        positive("tolerance of the heading [rad]", self.turn)?;
        Ok(())
    }

    /// Whether a pose is as close to the true one as this asks for.
    pub fn holds(&self, reported: Pose2, truth: Pose2) -> bool {
        let (x, y) = (reported.x - truth.x, reported.y - truth.y);
        x * x + y * y <= self.distance * self.distance
            && angle::difference(reported.theta, truth.theta).abs() <= self.turn
    }

    /// Share of the belief's weight within this tolerance of the reported pose: the probability
    /// that the robot is not lost, as far as the cloud itself knows. The weights must be
    /// normalised; 0 for a cloud without particles.
    pub fn support(&self, particles: &Particles, reported: Pose2) -> f64 {
        let near = |pose: &(Pose2, f64)| self.holds(reported, pose.0);
        let poses = particles.poses();
        let weighted = poses.iter().zip(particles.log_weights().iter().copied());
        weighted.filter(near).map(|(_, log_weight)| log_weight.exp()).sum::<f64>().min(1.0)
    }
}
