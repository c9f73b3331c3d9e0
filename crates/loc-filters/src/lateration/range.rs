//! The measurement: a distance to a landmark whose place is known.

use crate::Result;
use loc_core::error::{finite, non_negative, positive};
use nalgebra::Point;

/// A measured distance to a landmark, in the plane (`D` = 2) or in space (`D` = 3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range<const D: usize> {
    /// The landmark in the map \[m\]; `l_i` of D1 to D3.
    pub landmark: Point<f64, D>,
    /// The measured distance \[m\]; `d_i`.
    pub distance: f64,
    /// Its standard deviation \[m\]; `sigma_i`.
    pub sigma: f64,
}

impl<const D: usize> Range<D> {
    /// A distance \[m\] to a landmark at `landmark` \[m\], good to `sigma` \[m\].
    pub fn new(landmark: [f64; D], distance: f64, sigma: f64) -> Self {
        Range { landmark: Point::from(landmark), distance, sigma }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a distance that is negative, a sigma that is not
    /// positive, NaN and infinity.
    pub fn check(&self) -> Result<()> {
        for &coordinate in self.landmark.iter() {
            finite("position of a landmark [m]", coordinate)?;
        }
        non_negative("distance to a landmark [m]", self.distance)?;
        positive("sigma of a distance [m]", self.sigma)?;
        Ok(())
    }
}

/// Systematic errors of a ranging sensor: it reports `scale * distance + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeBias {
    /// Factor by which reported distances are too long.
    pub scale: f64,
    /// What is added to every distance \[m\].
    pub offset: f64,
}

impl RangeBias {
    /// A sensor that is right.
    pub const NONE: RangeBias = RangeBias { scale: 1.0, offset: 0.0 };

    /// What the sensor reports of a distance \[m\], noise left aside.
    pub fn reported(&self, distance: f64) -> f64 {
        self.scale * distance + self.offset
    }
}
