//! How far an observation may be off.

use crate::Result;
use loc_core::error::non_negative;

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
