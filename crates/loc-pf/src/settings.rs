//! All settings of Monte Carlo localization, with defaults that serve most robots.

use crate::motion::PathNoise;
use crate::tempering::TemperingSettings;
use crate::{Resampling, Result};
use loc_core::error::{non_negative, positive};
use loc_maps::likelihood_field::LikelihoodFieldSettings;

/// Settings of [`Mcl`](crate::Mcl).
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct MclSettings {
    /// Number of particles.
    pub particles: usize,
    /// Noise of the odometry.
    pub motion: PathNoise,
    /// The likelihood field.
    pub field: LikelihoodFieldSettings,
    /// Most beams of a scan that are used.
    pub beams: usize,
    /// As how many independent beams a scan counts, if it has more: its beams see the same walls,
    /// with the same errors of the map.
    pub independent_beams: f64,
    /// How narrow likelihoods are taken in.
    pub tempering: TemperingSettings,
    /// No update before the robot has driven this far \[m\] (`update_min_d`) ..
    pub update_distance: f64,
    /// .. or turned this much \[rad\] (`update_min_a`).
    pub update_turn: f64,
    /// How particles are drawn.
    pub resampling: Resampling,
    /// Number of threads.
    pub threads: usize,
}

impl Default for MclSettings {
    fn default() -> Self {
        MclSettings {
            particles: 500,
            motion: PathNoise::default(),
            field: LikelihoodFieldSettings {
                sigma_hit: 0.05,
                z_hit: 0.8,
                z_rand: 0.2,
                ..LikelihoodFieldSettings::default()
            },
            beams: 60,
            independent_beams: 20.0,
            tempering: TemperingSettings::default(),
            update_distance: 0.1,
            update_turn: 0.1,
            resampling: Resampling::default(),
            threads: 1,
        }
    }
}

impl MclSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] and [`loc_core::Error::Length`] naming the first that is not
    /// allowed.
    pub fn validate(&self) -> Result<()> {
        if self.particles == 0 {
            let (what, expected) = ("particles", "at least 1");
            return Err(loc_core::Error::Length { what, expected, found: 0 }.into());
        }
        self.field.validate()?;
        self.motion.validate()?;
        self.tempering.validate()?;
        positive("independent_beams", self.independent_beams)?;
        non_negative("update_distance [m]", self.update_distance)?;
        non_negative("update_turn [rad]", self.update_turn)?;
        Ok(())
    }
}
