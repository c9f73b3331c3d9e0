//! How far off a pose may be before it counts as lost.

use crate::elementary::{exp, wrap};
use crate::{Particles, Poses, Result};
use loc_core::error::positive;
use loc_core::{Pose2, angle};
use pulp::{Arch, Simd, WithSimd};

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
        Arch::new().dispatch(Support { tolerance: *self, particles, reported })
    }
}

/// Numbers added up side by side.
const LANES: usize = 8;

struct Support<'a> {
    tolerance: Tolerance,
    particles: &'a Particles,
    reported: Pose2,
}

impl WithSimd for Support<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let Support { tolerance: Tolerance { distance, turn }, particles, reported } = self;
        let Poses { x, y, theta } = particles.poses();
        let mut sums = [0.0; LANES];
        let chunks = x.chunks(LANES).zip(y.chunks(LANES)).zip(theta.chunks(LANES));
        for (((x, y), theta), weights) in chunks.zip(particles.log_weights().chunks(LANES)) {
            let poses = x.iter().zip(y).zip(theta).zip(weights);
            for (sum, (((x, y), theta), weight)) in sums.iter_mut().zip(poses) {
                let (dx, dy) = (x - reported.x, y - reported.y);
                let near = (dx * dx + dy * dy <= distance * distance)
                    & (wrap(theta - reported.theta).abs() <= turn);
                *sum += if near { exp(*weight) } else { 0.0 };
            }
        }
        sums.iter().sum::<f64>().min(1.0)
    }
}
