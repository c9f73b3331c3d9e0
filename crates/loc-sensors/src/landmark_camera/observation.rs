//! The measurement: one landmark, seen once.

use crate::Result;
use loc_core::error::{finite, non_negative};

/// One landmark as the camera reports it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LandmarkObservation {
    /// Number read off the landmark; it may be wrong.
    pub landmark: u32,
    /// Where it was seen.
    pub sight: Observed,
}

/// Where a landmark was seen from the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Observed {
    /// Distance \[m\] and direction, counter-clockwise from the camera's axis \[rad\].
    RangeBearing {
        /// Distance \[m\].
        range: f64,
        /// Direction \[rad\].
        bearing: f64,
    },
    /// Distance only \[m\].
    Range {
        /// Distance \[m\].
        range: f64,
    },
    /// Direction only \[rad\].
    Bearing {
        /// Direction \[rad\].
        bearing: f64,
    },
}

/// Which of the two numbers a camera delivers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum ObservedKind {
    /// Distance and direction.
    #[default]
    RangeBearing,
    /// Distance only.
    Range,
    /// Direction only.
    Bearing,
}

impl Observed {
    /// A sight of the given kind, from a distance \[m\] and a direction \[rad\].
    pub fn new(kind: ObservedKind, range: f64, bearing: f64) -> Self {
        match kind {
            ObservedKind::RangeBearing => Observed::RangeBearing { range, bearing },
            ObservedKind::Range => Observed::Range { range },
            ObservedKind::Bearing => Observed::Bearing { bearing },
        }
    }

    /// The distance \[m\], where it was measured.
    pub fn range(self) -> Option<f64> {
        match self {
            Observed::RangeBearing { range, .. } | Observed::Range { range } => Some(range),
            Observed::Bearing { .. } => None,
        }
    }

    /// The direction \[rad\], where it was measured.
    pub fn bearing(self) -> Option<f64> {
        match self {
            Observed::RangeBearing { bearing, .. } | Observed::Bearing { bearing } => Some(bearing),
            Observed::Range { .. } => None,
        }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a negative distance, and for NaN and infinity.
    pub fn check(self) -> Result<Self> {
        self.range().map_or(Ok(0.0), |range| non_negative("range to a landmark [m]", range))?;
        self.bearing().map_or(Ok(0.0), |bearing| finite("bearing of a landmark [rad]", bearing))?;
        Ok(self)
    }
}
