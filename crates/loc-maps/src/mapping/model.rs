//! What one beam says about the cells it meets.

use crate::Result;
use loc_core::error::{finite, non_negative, positive, probability};

/// The inverse sensor model: how much a beam changes what is believed of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct InverseSensorModel {
    /// Log-odds that the cell at a beam's end gains; also known as l_occ.
    pub hit: f64,
    /// Log-odds that a cell along a beam loses; also known as l_free, with its sign turned.
    pub miss: f64,
    /// Largest log-odds, of either sign, so that a cell can still change its mind.
    pub limit: f64,
    /// Beams are followed no farther than this \[m\].
    pub max_range: f64,
    /// How far a beam that met nothing clears the way \[m\]; 0 for not at all.
    pub clear_without_return: f64,
    /// Probability from which on a cell is occupied.
    pub occupied: f64,
    /// Probability up to which a cell is free.
    pub free: f64,
}

impl InverseSensorModel {
    /// Checks every value.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for values that are negative or not finite, probabilities
    /// outside \[0, 1\], and a free threshold above the occupied one.
    pub fn check(&self) -> Result<()> {
        positive("log-odds of a hit", self.hit)?;
        positive("log-odds of a miss", self.miss)?;
        positive("limit of the log-odds", self.limit)?;
        positive("longest beam [m]", self.max_range)?;
        non_negative("way cleared without return [m]", self.clear_without_return)?;
        probability("probability of an occupied cell", self.occupied)?;
        probability("probability of a free cell", self.free)?;
        finite("probabilities", self.occupied - self.free)?;
        non_negative("occupied minus free threshold", self.occupied - self.free)?;
        Ok(())
    }
}

impl Default for InverseSensorModel {
    /// A hit weighs twice as much as a miss; one beam decides where others are silent, and
    /// a hit and a miss leave a cell undecided.
    fn default() -> Self {
        InverseSensorModel {
            hit: 0.85,
            miss: 0.4,
            limit: 10.0,
            max_range: 30.0,
            clear_without_return: 0.0,
            occupied: 0.65,
            free: 0.45,
        }
    }
}
