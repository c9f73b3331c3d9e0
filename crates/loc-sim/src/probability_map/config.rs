//! The configuration of a probability map.

use crate::Result;
use crate::config::field;
use crate::source::tour::{LaserConfig, PoseConfig, WorldConfig};
use loc_core::error::positive;
use loc_maps::likelihood_field::LikelihoodFieldSettings;
use serde::Deserialize;
use std::path::PathBuf;

/// A scan to be rated everywhere.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProbabilityMapConfig {
    /// A generated world. Either this or `map`.
    pub world: Option<WorldConfig>,
    /// A map of map_server, from the folder that the command runs in.
    pub map: Option<PathBuf>,
    /// Where the scan is taken.
    pub pose: PoseConfig,
    /// The laser; `every_s` has no meaning here.
    pub laser: LaserConfig,
    /// How likely a beam's end is near an obstacle.
    #[serde(default)]
    pub field: LikelihoodFieldSettings,
    /// Most beams of the scan that are used.
    #[serde(default = "beams")]
    pub beams: usize,
    /// Number of headings that are tried at each place, 1 to 3600.
    #[serde(default = "headings")]
    pub headings: usize,
    /// Distance between the places.
    #[serde(default = "step")]
    pub step_m: f64,
    /// The colours reach from the highest likelihood down to one that is so many powers of ten
    /// lower.
    #[serde(default = "decades")]
    pub decades: f64,
}

fn beams() -> usize {
    60
}

fn headings() -> usize {
    120
}

fn step() -> f64 {
    0.1
}

fn decades() -> f64 {
    20.0
}

impl ProbabilityMapConfig {
    /// Checks every value, as far as that is possible without the building.
    ///
    /// # Errors
    /// [`crate::Error::Config`] and [`loc_core::Error::OutOfRange`] with the key.
    pub(crate) fn check(&self) -> Result<()> {
        if let Some(world) = &self.world {
            world.settings()?;
        }
        self.pose.check("probability_map.pose")?;
        self.laser.scanner()?;
        self.field.validate()?;
        if self.beams == 0 {
            return Err(field("probability_map.beams", "at least 1", "0"));
        }
        if !(1..=3600).contains(&self.headings) {
            let found = self.headings.to_string();
            return Err(field("probability_map.headings", "1 to 3600", &found));
        }
        positive("probability_map.step_m", self.step_m)?;
        positive("probability_map.decades", self.decades)?;
        Ok(())
    }
}
