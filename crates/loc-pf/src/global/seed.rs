//! From candidates to a cloud.

use super::Candidate;
use crate::{Particles, Result};
use loc_core::Pose2;
use loc_core::error::{non_negative, positive};
use loc_core::sampling::box_muller;
use rand::{Rng, RngExt};

/// How particles are spread over the candidates of a search.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct SeedSettings {
    /// Standard deviation of the position about a candidate, along each axis \[m\].
    pub position: f64,
    /// Standard deviation of the heading \[rad\].
    pub heading: f64,
    /// Power to which the likelihoods are raised. The beams of a scan depend on each other, so
    /// that the likelihood of 180 of them says far more than is known; low powers keep second
    /// guesses alive.
    pub exponent: f64,
}

impl Default for SeedSettings {
    fn default() -> Self {
        SeedSettings { position: 0.1, heading: 0.03, exponent: 0.1 }
    }
}

impl SeedSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] naming the first that is not allowed.
    pub fn validate(&self) -> Result<()> {
        non_negative("position [m]", self.position)?;
        non_negative("heading [rad]", self.heading)?;
        positive("exponent", self.exponent)?;
        Ok(())
    }
}

/// A cloud of `count` particles of equal weight about the candidates: each has a share in
/// proportion to its likelihood to the power of `exponent`, exact but for one particle, and spreads
/// it as a Gaussian.
///
/// ```
/// use loc_core::{Pose2, random::stream};
/// use loc_pf::global::{Candidate, SeedSettings, seed_particles};
/// let here = Candidate { pose: Pose2::new(5.0, 5.0, 0.0), log_likelihood: -20.0 };
/// let there = Candidate { pose: Pose2::new(9.0, 5.0, 3.1), log_likelihood: -30.0 };
/// let mut rng = stream(1, "filter");
/// let cloud = seed_particles(&[here, there], 1000, &SeedSettings::default(), &mut rng)?;
/// let at_first = cloud.poses().x.iter().filter(|x| **x < 7.0).count();
/// assert!(at_first.abs_diff(731) <= 1, "e : 1");
/// # Ok::<(), loc_pf::Error>(())
/// ```
///
/// # Errors
/// Settings out of range, and [`loc_core::Error::Length`] without candidates.
pub fn seed_particles<R: Rng + ?Sized>(
    candidates: &[Candidate],
    count: usize,
    settings: &SeedSettings,
    rng: &mut R,
) -> Result<Particles> {
    settings.validate()?;
    let best = candidates.iter().map(|candidate| candidate.log_likelihood).reduce(f64::max);
    let Some(best) = best else {
        let (what, expected) = ("candidates", "at least 1");
        return Err(loc_core::Error::Length { what, expected, found: 0 }.into());
    };
    let weight = |c: &Candidate| (settings.exponent * (c.log_likelihood - best)).exp();
    let total: f64 = candidates.iter().map(weight).sum();
    // The spoke wheel: one draw decides all shares.
    let offset: f64 = rng.random();
    let (mut sum, mut drawn, mut poses) = (0.0, 0, Vec::with_capacity(count));
    for (number, candidate) in candidates.iter().enumerate() {
        sum += weight(candidate) / total * count as f64;
        let last = number + 1 == candidates.len();
        let until = if last { count } else { ((sum + offset) as usize).min(count) };
        poses.extend((drawn..until).map(|_| spread(candidate.pose, settings, rng)));
        drawn = drawn.max(until);
    }
    Ok(Particles::from_poses(poses))
}

fn spread<R: Rng + ?Sized>(at: Pose2, settings: &SeedSettings, rng: &mut R) -> Pose2 {
    let ((x, y), (turn, _)) = (box_muller(rng), box_muller(rng));
    let SeedSettings { position, heading, .. } = settings;
    Pose2::new(at.x + position * x, at.y + position * y, at.theta + heading * turn)
}
