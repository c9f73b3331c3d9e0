//! The measurement: one landmark, seen once.

use crate::Result;
use loc_core::error::{finite, non_negative, positive};

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

// How far an observation may be off.

/// Independent normal errors of distance and direction.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct LandmarkNoise {
    /// Standard deviation of the distance at the camera \[m\]; also known as sigma_r.
    pub range_sigma: f64,
    /// Its growth with the distance \[m/m\].
    pub range_sigma_per_m: f64,
    /// Standard deviation of the direction \[rad\]; also known as sigma_phi.
    pub bearing_sigma: f64,
}

impl LandmarkNoise {
    /// A perfect camera.
    pub const NONE: LandmarkNoise =
        LandmarkNoise { range_sigma: 0.0, range_sigma_per_m: 0.0, bearing_sigma: 0.0 };

    /// Standard deviation of a distance of `range` \[m\].
    pub fn range_sigma_at(&self, range: f64) -> f64 {
        self.range_sigma + self.range_sigma_per_m * range
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for negative values, NaN and infinity.
    pub fn check(&self) -> Result<()> {
        non_negative("sigma of the range [m]", self.range_sigma)?;
        non_negative("growth of the range's sigma [m/m]", self.range_sigma_per_m)?;
        non_negative("sigma of the bearing [rad]", self.bearing_sigma)?;
        Ok(())
    }
}

impl Default for LandmarkNoise {
    /// 5 cm and 1 degree, as a small camera on a desk-sized robot reaches.
    fn default() -> Self {
        LandmarkNoise {
            range_sigma: 0.05,
            range_sigma_per_m: 0.0,
            bearing_sigma: 1_f64.to_radians(),
        }
    }
}

// Correcting what a real camera reports.

/// How a recorded sight becomes distance and direction from the camera.
///
/// A camera that infers the distance from a landmark's size in the image measures the *depth*
/// along its optical axis, not the distance: `reported = scale * distance * cos(bearing)`. The
/// error is nothing straight ahead and a seventh at 30 degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct CameraCalibration {
    /// Factor by which reported distances are too long (focal length).
    pub range_scale: f64,
    /// Whether the reported distance is the depth along the optical axis. Needs a bearing.
    pub range_is_depth: bool,
    /// Angle added to every direction by a camera turned on its mount \[rad\].
    pub bearing_bias: f64,
    /// Time from the sight to its stamp \[s\].
    pub delay: f64,
}

impl CameraCalibration {
    /// The camera is right as it is.
    pub const NONE: CameraCalibration = CameraCalibration {
        range_scale: 1.0,
        range_is_depth: false,
        bearing_bias: 0.0,
        delay: 0.0,
    };

    /// Beyond this direction \[rad\] a depth says too little about a distance.
    pub const WIDEST_DEPTH_BEARING: f64 = 1.4;

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a scale that is not positive, and for values that are not
    /// finite.
    pub fn check(&self) -> Result<()> {
        positive("range scale", self.range_scale)?;
        finite("bearing bias [rad]", self.bearing_bias)?;
        finite("camera delay [s]", self.delay)?;
        Ok(())
    }

    /// Distance and direction, of a recorded sight.
    ///
    /// A depth that was seen wider than [`Self::WIDEST_DEPTH_BEARING`] keeps its direction only.
    pub fn correct(&self, recorded: Observed) -> Observed {
        match recorded {
            Observed::RangeBearing { range, bearing } => self.correct_both(range, bearing),
            Observed::Range { range } => Observed::Range { range: range / self.range_scale },
            Observed::Bearing { bearing } => {
                Observed::Bearing { bearing: bearing - self.bearing_bias }
            }
        }
    }

    fn correct_both(&self, range: f64, bearing: f64) -> Observed {
        let direction = bearing - self.bearing_bias;
        let range = range / self.range_scale;
        if !self.range_is_depth {
            return Observed::RangeBearing { range, bearing: direction };
        }
        // The optical axis turns with the camera, so the depth follows the reported direction.
        if bearing.abs() > Self::WIDEST_DEPTH_BEARING {
            return Observed::Bearing { bearing: direction };
        }
        Observed::RangeBearing { range: range / bearing.cos(), bearing: direction }
    }
}

impl Default for CameraCalibration {
    fn default() -> Self {
        CameraCalibration::NONE
    }
}
