//! All settings of grid localization, with defaults that serve most robots.

use crate::Result;
use loc_core::error::{in_range, non_negative, positive, probability};
use loc_core::motion::PathNoise;
use loc_maps::likelihood_field::{LikelihoodFieldSettings, Obstacles};
use std::f64::consts::PI;

/// Settings of a [`GridLocalizer`](super::GridLocalizer).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct GridSettings {
    /// Side of a cell of the grid over the whole map \[m\], rounded to whole cells of the map.
    pub cell: f64,
    /// Largest step from one heading to the next \[rad\]; the full turn is divided evenly.
    pub heading: f64,
    /// The fine grid that follows the most likely place.
    pub fine: FineSettings,
    /// How far odometry may be off.
    pub motion: PathNoise,
    /// How likely a beam's end is, by its distance from the nearest obstacle. `sigma_hit` is at
    /// least the side of a map cell.
    pub field: LikelihoodFieldSettings,
    /// Maximum number of beams of a scan that are used.
    pub beams: usize,
    /// As how many independent beams a scan counts, if it has more: its beams see the same walls,
    /// with the same errors of the map.
    pub independent_beams: f64,
    /// Beams shorter than this are not used \[m\].
    pub min_range: f64,
    /// Beams longer than this are not used \[m\].
    pub max_range: f64,
    /// Probability that the robot is kidnapped, or delocalized, between two updates: the share of a
    /// uniform distribution that is mixed in at each of them.
    pub kidnap_rate: f64,
    /// Cells are passed over as long as all of them together have at most this share in the result.
    pub negligible: f64,
    /// No update before the robot has driven this far \[m\] ..
    pub update_distance: f64,
    /// .. or turned this much \[rad\].
    pub update_turn: f64,
}

/// The fine grid that follows the most likely place.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct FineSettings {
    /// Side of a cell \[m\].
    pub cell: f64,
    /// Step from one heading to the next \[rad\].
    pub heading: f64,
    /// How far it reaches from its middle, along both axes of the map \[m\].
    pub reach: f64,
    /// How far it reaches to both sides of its middle heading \[rad\].
    pub turn: f64,
    /// It is opened at the most likely place once that has this probability.
    pub from_share: f64,
}

impl Default for FineSettings {
    fn default() -> Self {
        FineSettings {
            cell: 0.04,
            heading: 0.5_f64.to_radians(),
            reach: 0.6,
            turn: 15_f64.to_radians(),
            from_share: 0.2,
        }
    }
}

impl Default for GridSettings {
    fn default() -> Self {
        GridSettings {
            cell: 0.2,
            heading: 5_f64.to_radians(),
            fine: FineSettings::default(),
            motion: PathNoise::default(),
            field: LikelihoodFieldSettings {
                sigma_hit: 0.05,
                z_hit: 0.8,
                z_rand: 0.2,
                obstacles: Obstacles::Surfaces,
                ..LikelihoodFieldSettings::default()
            },
            beams: 60,
            independent_beams: 20.0,
            min_range: 0.0,
            max_range: 100.0,
            kidnap_rate: 1e-3,
            negligible: 1e-4,
            update_distance: 0.1,
            update_turn: 0.1,
        }
    }
}

impl GridSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] naming the first that is not allowed.
    pub fn validate(&self) -> Result<()> {
        positive("cell [m]", self.cell)?;
        let step = |step: f64| (1e-3..=PI).contains(&step);
        in_range("heading [rad]", "0.001 to pi", self.heading, step)?;
        self.fine.validate()?;
        self.motion.validate()?;
        self.field.validate()?;
        let beams = |beams: f64| (1.0..=10_000.0).contains(&beams);
        in_range("beams", "1 to 10000", self.beams as f64, beams)?;
        positive("independent_beams", self.independent_beams)?;
        non_negative("min_range [m]", self.min_range)?;
        positive("max_range [m]", self.max_range)?;
        probability("kidnap_rate", self.kidnap_rate)?;
        let small = |share: f64| (0.0..=0.1).contains(&share);
        in_range("negligible", "0 to 0.1", self.negligible, small)?;
        non_negative("update_distance [m]", self.update_distance)?;
        non_negative("update_turn [rad]", self.update_turn)?;
        Ok(())
    }
}

impl FineSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] naming the first that is not allowed.
    pub fn validate(&self) -> Result<()> {
        positive("fine.cell [m]", self.cell)?;
        let step = |step: f64| (1e-4..=PI).contains(&step);
        in_range("fine.heading [rad]", "0.0001 to pi", self.heading, step)?;
        positive("fine.reach [m]", self.reach)?;
        let turn = |turn: f64| turn > 0.0 && turn <= PI;
        in_range("fine.turn [rad]", "a number above 0 and up to pi", self.turn, turn)?;
        let share = |share: f64| share > 0.0 && share <= 1.0;
        in_range("fine.from_share", "a number above 0 and up to 1", self.from_share, share)?;
        Ok(())
    }
}
