//! What became of an observation.

use crate::Innovation;

/// An observation's landmark and what the filter made of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// The number that was read off the landmark.
    pub landmark: u32,
    /// Whether and why it was believed.
    pub verdict: Verdict,
}

/// What the filter made of an observation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// The map has no landmark of this number; nothing was changed.
    UnknownLandmark,
    /// Distance and direction were held against the expectation.
    RangeBearing(Innovation<2>),
    /// The distance was.
    Range(Innovation<1>),
    /// The direction was.
    Bearing(Innovation<1>),
}

impl Outcome {
    /// Whether the observation changed the belief.
    pub fn accepted(&self) -> bool {
        match &self.verdict {
            Verdict::UnknownLandmark => false,
            Verdict::RangeBearing(innovation) => innovation.accepted,
            Verdict::Range(innovation) | Verdict::Bearing(innovation) => innovation.accepted,
        }
    }

    /// The normalised innovation squared; `None` for an unknown landmark.
    pub fn nis(&self) -> Option<f64> {
        match &self.verdict {
            Verdict::UnknownLandmark => None,
            Verdict::RangeBearing(innovation) => Some(innovation.nis),
            Verdict::Range(innovation) | Verdict::Bearing(innovation) => Some(innovation.nis),
        }
    }

    /// How many numbers were measured: the mean of the NIS of a consistent filter.
    pub fn degrees_of_freedom(&self) -> usize {
        match &self.verdict {
            Verdict::UnknownLandmark => 0,
            Verdict::RangeBearing(_) => 2,
            Verdict::Range(_) | Verdict::Bearing(_) => 1,
        }
    }
}
