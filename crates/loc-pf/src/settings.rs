//! All settings of Monte Carlo localization, with defaults that serve most robots.

use crate::{Resampling, Result};
use loc_core::error::{non_negative, positive};
use loc_core::motion::OdometryNoise;
use loc_maps::likelihood_field::LikelihoodFieldSettings;

/// Settings of [`Mcl`](crate::Mcl).
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct MclSettings {
    /// Number of particles.
    pub particles: usize,
    /// Noise of the odometry.
    pub motion: OdometryNoise,
    /// The likelihood field.
    pub field: LikelihoodFieldSettings,
    /// Most beams of a scan that are used.
    pub beams: usize,
    /// Power to which the likelihood of a scan is raised.
    pub scan_exponent: f64,
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
            particles: 2000,
            motion: OdometryNoise { alpha1: 0.2, alpha2: 0.2, alpha3: 0.2, alpha4: 0.2 },
            field: LikelihoodFieldSettings::default(),
            beams: 60,
            scan_exponent: 1.0,
            update_distance: 0.25,
            update_turn: 0.2,
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
        positive("scan_exponent", self.scan_exponent)?;
        non_negative("update_distance [m]", self.update_distance)?;
        non_negative("update_turn [rad]", self.update_turn)?;
        Ok(())
    }
}
