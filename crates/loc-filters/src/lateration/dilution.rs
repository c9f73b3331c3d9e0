//! How geometry magnifies the noise of ranges.

use crate::{Error, Result};
use nalgebra::{Point, SMatrix, SVector};

/// Dilution of precision: standard deviation of a place by that of the ranges, if all are equally
/// good; the square roots of the diagonal of `(H^T H)^-1`, with the directions to the landmarks as
/// the rows of H.
///
/// It is about 1 in the middle of landmarks all around. Infinity says that to first order the
/// ranges do not determine that axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dilution<const D: usize> {
    /// Along each axis of the map.
    pub axes: SVector<f64, D>,
}

impl<const D: usize> Dilution<D> {
    /// The dilution at `place` \[m\] of ranges to `landmarks` \[m\].
    ///
    /// ```
    /// use loc_filters::lateration::Dilution;
    /// let crossed = Dilution::at(&[0.0, 0.0].into(), [[5.0, 0.0].into(), [0.0, 5.0].into()])?;
    /// assert!((crossed.position() - 2_f64.sqrt()).abs() < 1e-12);
    /// let flat = Dilution::at(&[0.0, 0.0].into(), [[5.0, 0.0].into(), [5.0, 0.5].into()])?;
    /// assert!(flat.position() > 14.0, "a small angle between the circles");
    /// # Ok::<(), loc_filters::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::TooFewRanges`] for fewer landmarks than coordinates.
    pub fn at(
        place: &Point<f64, D>,
        landmarks: impl IntoIterator<Item = Point<f64, D>>,
    ) -> Result<Self> {
        let (mut matrix, mut count) = (SMatrix::<f64, D, D>::zeros(), 0);
        for landmark in landmarks {
            let way = place - landmark;
            // At a landmark its range has no direction and says nothing to first order.
            let direction = way.try_normalize(0.0).unwrap_or_else(SVector::zeros);
            matrix.ger(1.0, &direction, &direction, 1.0);
            count += 1;
        }
        if count < D {
            return Err(Error::TooFewRanges { expected: D, found: count });
        }
        let smallest = 1e-12 * matrix.trace();
        let axes = match matrix.cholesky() {
            Some(factor) if factor.l_dirty().diagonal().iter().all(|d| d * d > smallest) => {
                factor.inverse().diagonal().map(f64::sqrt)
            }
            _ => SVector::repeat(f64::INFINITY),
        };
        Ok(Dilution { axes })
    }

    /// That of the place as a whole; also known as PDOP, in the plane HDOP.
    pub fn position(&self) -> f64 {
        self.axes.norm()
    }
}

impl Dilution<3> {
    /// That of the place in the plane; also known as HDOP.
    pub fn horizontal(&self) -> f64 {
        self.axes.xy().norm()
    }

    /// That of the height; also known as VDOP.
    pub fn vertical(&self) -> f64 {
        self.axes.z
    }
}
