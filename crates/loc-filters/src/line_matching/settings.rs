//! The settings of line matching.

use crate::{Gate, Result};
use loc_core::error::{non_negative, positive, probability};
use loc_core::motion::PathNoise;
use loc_sensors::features::LineExtractor;

/// All that line matching can be told, with defaults that serve a small indoor robot.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct LineMatchingSettings {
    /// How far odometry may be off.
    pub motion: PathNoise,
    /// How lines are found in scans, and what the scanner's noise is.
    pub extractor: LineExtractor,
    /// How far each end of a map line may be off across it, as a standard deviation \[m\]: 0 for
    /// a drawing, about half a cell for lines that were found in a grid.
    pub map_sigma: f64,
    /// Map lines that are shorter are not matched; they still hide others \[m\].
    pub min_map_length: f64,
    /// Share of right pairs of lines that the gate lets pass, 1 for no gate.
    pub gate_probability: f64,
    /// The share of the shorter of two lines that must lie beside the other one.
    pub min_overlap: f64,
    /// How far a wall may be seen beyond the stretch that is predicted, two standard deviations of
    /// the position beside \[m\].
    pub slack: f64,
    /// When the robot counts as lost.
    pub lost: LostSettings,
}

/// When line matching says that it has lost the robot.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct LostSettings {
    /// A scan fits where at least this share of its lines has partners, by length.
    pub min_share: f64,
    /// Fewer lines say nothing about it.
    pub min_lines: usize,
    /// After so many scans in a row that do not fit, the robot is lost.
    pub scans: usize,
}

impl LineMatchingSettings {
    /// Checks every value and computes the gate.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] naming the first value that is not allowed.
    pub(super) fn gate(&self) -> Result<Gate> {
        self.motion.validate()?;
        self.extractor.check()?;
        non_negative("sigma of the ends of map lines [m]", self.map_sigma)?;
        positive("least length of map lines [m]", self.min_map_length)?;
        probability("least overlap of lines", self.min_overlap)?;
        non_negative("slack of the ends of walls [m]", self.slack)?;
        probability("least share of matched lines", self.lost.min_share)?;
        Gate::probability(self.gate_probability)
    }
}

impl Default for LineMatchingSettings {
    fn default() -> Self {
        LineMatchingSettings {
            motion: PathNoise::default(),
            extractor: LineExtractor::default(),
            map_sigma: 0.0,
            min_map_length: 0.3,
            gate_probability: 0.99,
            min_overlap: 0.5,
            slack: 0.3,
            lost: LostSettings::default(),
        }
    }
}

impl Default for LostSettings {
    /// Ten scans in a row of which less than a third of the lines, by length, has partners.
    fn default() -> Self {
        LostSettings { min_share: 1.0 / 3.0, min_lines: 2, scans: 10 }
    }
}
