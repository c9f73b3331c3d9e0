//! What became of an observation, and what the map holds.

use crate::Innovation;
use loc_core::Gaussian;

/// An observation's landmark and what the filter made of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlamOutcome {
    /// Number of the landmark in the map: as it was read, or as the filter gave it. `None` for a
    /// observation that it found no landmark for.
    pub landmark: Option<u32>,
    /// Whether and why it was believed.
    pub verdict: SlamVerdict,
}

/// What the filter made of an observation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SlamVerdict {
    /// Distance and direction were held against the expectation.
    RangeBearing(Innovation<2>),
    /// The distance was.
    Range(Innovation<1>),
    /// The direction was.
    Bearing(Innovation<1>),
    /// A new landmark entered the map.
    Born,
    /// It fits no landmark well enough to be of it, and one too well to be of a new one; the NIS
    /// with the nearest one. Nothing was changed.
    Ambiguous(f64),
    /// Something new without a distance or a direction, or so near that it has none; nothing was
    /// changed.
    Unplaceable,
    /// Something new for which the map has no room; nothing was changed.
    MapFull,
}

impl SlamOutcome {
    /// Whether the observation changed the belief.
    pub fn accepted(&self) -> bool {
        match &self.verdict {
            SlamVerdict::RangeBearing(innovation) => innovation.accepted,
            SlamVerdict::Range(innovation) | SlamVerdict::Bearing(innovation) => {
                innovation.accepted
            }
            SlamVerdict::Born => true,
            _ => false,
        }
    }

    /// The normalised innovation squared, of an observation that was held against a landmark.
    pub fn nis(&self) -> Option<f64> {
        match &self.verdict {
            SlamVerdict::RangeBearing(innovation) => Some(innovation.nis),
            SlamVerdict::Range(innovation) | SlamVerdict::Bearing(innovation) => {
                Some(innovation.nis)
            }
            _ => None,
        }
    }

    /// How many numbers were held against a landmark: the mean of the NIS of a consistent filter.
    pub fn degrees_of_freedom(&self) -> usize {
        match &self.verdict {
            SlamVerdict::RangeBearing(_) => 2,
            SlamVerdict::Range(_) | SlamVerdict::Bearing(_) => 1,
            _ => 0,
        }
    }
}

/// A landmark of the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapLandmark {
    /// Its number.
    pub id: u32,
    /// Where it is believed to be \[m\].
    pub position: Gaussian<2>,
    /// How many observations it was corrected with, the first one included.
    pub observations: u32,
    /// Whether it was seen often enough to be believed in; a landmark that is not may be removed
    /// again.
    pub confirmed: bool,
}
