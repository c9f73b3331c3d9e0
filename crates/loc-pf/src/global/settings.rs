//! What a search looks for.

use crate::Result;
use loc_core::error::{in_range, non_negative};

/// Settings of a [`GlobalSearch`](super::GlobalSearch).
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct SearchSettings {
    /// Largest step from one heading to the next \[rad\], 0.001 to 1; the full turn is divided
    /// evenly. A beam of length r ends up to half a step times r from where it should.
    pub angle_step: f64,
    /// Most candidates that are wanted.
    pub candidates: usize,
    /// Two candidates are at least this far apart \[m\] ..
    pub separation_distance: f64,
    /// .. or turned this much against each other \[rad\].
    pub separation_angle: f64,
    /// How much a candidate's log-likelihood may be below the best one's, mean over the beams.
    pub within: f64,
    /// The least log-likelihood of a candidate, mean over the beams.
    pub least: Option<f64>,
    /// Whether candidates are refined, see [`GlobalSearch::refine`](super::GlobalSearch::refine).
    pub refine: bool,
    /// Number of threads.
    pub threads: usize,
}

impl Default for SearchSettings {
    fn default() -> Self {
        SearchSettings {
            angle_step: 1_f64.to_radians(),
            candidates: 5,
            separation_distance: 1.0,
            separation_angle: 30_f64.to_radians(),
            within: 0.1,
            least: None,
            refine: true,
            threads: 1,
        }
    }
}

impl SearchSettings {
    /// Number of headings: even steps of at most `angle_step` in a full turn.
    pub(super) fn headings(&self) -> usize {
        // A step that divides the turn but for rounding is not cut.
        (std::f64::consts::TAU / self.angle_step - 1e-6).ceil().max(1.0) as usize
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] and [`loc_core::Error::Length`] naming the first that is not
    /// allowed.
    pub fn validate(&self) -> Result<()> {
        let step = |step: f64| (0.001..=1.0).contains(&step);
        in_range("angle_step [rad]", "0.001 to 1", self.angle_step, step)?;
        if self.candidates == 0 {
            let (what, expected) = ("candidates", "at least 1");
            return Err(loc_core::Error::Length { what, expected, found: 0 }.into());
        }
        non_negative("separation_distance [m]", self.separation_distance)?;
        non_negative("separation_angle [rad]", self.separation_angle)?;
        non_negative("within", self.within)?;
        if let Some(least) = self.least {
            loc_core::error::finite("least", least)?;
        }
        Ok(())
    }
}
