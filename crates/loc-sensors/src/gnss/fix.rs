//! The measurement: one position.

use super::{Geodetic, LocalFrame};
use loc_core::Gaussian;
use nalgebra::{Matrix3, Vector2};

/// One position as the receiver reports it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GnssFix {
    /// Where the receiver believes to be.
    pub position: Geodetic,
    /// Covariance of east, north and up that it claims \[m^2\].
    pub covariance: Matrix3<f64>,
}

impl GnssFix {
    /// The position in the plane of a local frame, east and north \[m\].
    pub fn in_plane(&self, frame: &LocalFrame) -> Gaussian<2> {
        let enu = frame.to_enu(&self.position);
        let covariance = self.covariance.fixed_view::<2, 2>(0, 0).into();
        Gaussian { mean: Vector2::new(enu.x, enu.y), covariance }
    }
}
