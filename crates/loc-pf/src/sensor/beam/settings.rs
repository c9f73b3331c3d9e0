//! The parameters of the beam model.

use crate::Result;
use loc_core::error::{in_range, non_negative, positive};

/// Parameters of a [`BeamModel`](super::BeamModel); the defaults are those of nav2_amcl.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct BeamModelSettings {
    /// Mixture or plain Gaussian.
    pub form: BeamForm,
    /// Share of the beams that measure the obstacle of the map (`z_hit`).
    pub z_hit: f64,
    /// Share of those that something stops before it, such as people (`z_short`).
    pub z_short: f64,
    /// Share of those that nothing returns (`z_max`).
    pub z_max: f64,
    /// Share of those that measure anything (`z_rand`).
    pub z_rand: f64,
    /// Standard deviation of what measures the obstacle \[m\] (`sigma_hit`).
    pub sigma_hit: f64,
    /// How quickly it grows unlikely with the distance that something stands in the way \[1/m\]
    /// (`lambda_short`).
    pub lambda_short: f64,
    /// Longest range \[m\] (`laser_max_range`); a scanner with a shorter one decides itself.
    pub max_range: f64,
}

/// What the density of a range looks like.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum BeamForm {
    /// Hit, short, max and random together.
    #[default]
    Mixture,
    /// `N(measured; expected, sigma_hit^2)` alone (M6). Where nothing returns, and where nothing is
    /// expected to, the range counts as `max_range`. A single person in the way can rule out the
    /// true pose: for simulations and comparisons.
    Gaussian,
}

impl Default for BeamModelSettings {
    fn default() -> Self {
        BeamModelSettings {
            form: BeamForm::Mixture,
            z_hit: 0.5,
            z_short: 0.05,
            z_max: 0.05,
            z_rand: 0.5,
            sigma_hit: 0.2,
            lambda_short: 0.1,
            max_range: 100.0,
        }
    }
}

impl BeamModelSettings {
    /// The same with shares that add up to 1.
    ///
    /// # Errors
    /// Those of [`validate`](Self::validate).
    pub fn normalized(&self) -> Result<Self> {
        self.validate()?;
        let total = self.z_hit + self.z_short + self.z_max + self.z_rand;
        Ok(BeamModelSettings {
            z_hit: self.z_hit / total,
            z_short: self.z_short / total,
            z_max: self.z_max / total,
            z_rand: self.z_rand / total,
            ..*self
        })
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] naming the first that is not allowed: shares that are
    /// negative or all 0, lengths and rates that are not above 0.
    pub fn validate(&self) -> Result<()> {
        non_negative("z_hit", self.z_hit)?;
        non_negative("z_short", self.z_short)?;
        non_negative("z_max", self.z_max)?;
        non_negative("z_rand", self.z_rand)?;
        let total = self.z_hit + self.z_short + self.z_max + self.z_rand;
        positive("z_hit + z_short + z_max + z_rand", total)?;
        positive("sigma_hit [m]", self.sigma_hit)?;
        positive("lambda_short [1/m]", self.lambda_short)?;
        let expected = "a number from 0.01 to 100000";
        let sane = |range: f64| (0.01..=1e5).contains(&range);
        in_range("max_range [m]", expected, self.max_range, sane)?;
        Ok(())
    }
}
