//! Correcting what a real camera reports.

use super::Observed;
use crate::Result;
use loc_core::error::{finite, positive};

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
