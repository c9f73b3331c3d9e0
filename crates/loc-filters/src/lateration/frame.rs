//! Ranges at their own scale: about their middle, in units of their extent.
//!
//! Coordinates of millions of metres and ranges of millimetres so keep all their digits.

use super::{BiasPrior, Fix, Range};
use crate::{Error, Result};
use nalgebra::{Point, SVector};

/// Extents whose fourth powers are neither 0 nor infinite.
const EXTENTS: std::ops::RangeInclusive<f64> = 1e-70..=1e70;

/// Where ranges lie and how large they are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame<const D: usize> {
    middle: SVector<f64, D>,
    extent: f64,
}

impl<const D: usize> Frame<D> {
    /// The frame of ranges that are checked.
    ///
    /// # Errors
    /// [`Error::Undetermined`] for sizes that no square can hold.
    pub(super) fn of(ranges: &[Range<D>]) -> Result<Self> {
        let share = 1.0 / ranges.len().max(1) as f64;
        let middle: SVector<f64, D> = ranges.iter().map(|r| r.landmark.coords * share).sum();
        let size = |r: &Range<D>| (r.landmark.coords - middle).norm() + r.distance + r.sigma;
        let extent = ranges.iter().map(size).fold(f64::MIN_POSITIVE, f64::max);
        if !EXTENTS.contains(&extent) {
            return Err(Error::Undetermined {
                expected: "coordinates and distances from 1e-70 m to 1e70 m",
                found: format!("{extent:e} m"),
            });
        }
        Ok(Frame { middle, extent })
    }

    /// A place of the map in this frame.
    pub(super) fn place(&self, place: &Point<f64, D>) -> Point<f64, D> {
        Point::from((place.coords - self.middle) / self.extent)
    }

    /// A range of the map in this frame.
    pub(super) fn range(&self, range: &Range<D>) -> Range<D> {
        Range {
            landmark: self.place(&range.landmark),
            distance: range.distance / self.extent,
            sigma: range.sigma / self.extent,
        }
    }

    /// What is known of the bias, in this frame.
    pub(super) fn bias(&self, bias: BiasPrior) -> BiasPrior {
        BiasPrior { offset_sigma: bias.offset_sigma / self.extent, ..bias }
    }

    /// A fix of this frame in the map.
    pub(super) fn fix_in_map(&self, mut fix: Fix<D>) -> Fix<D> {
        fix.position = Point::from(self.middle + fix.position.coords * self.extent);
        fix.covariance *= self.extent * self.extent;
        fix.bias.offset *= self.extent;
        fix.bias_sigmas[1] *= self.extent;
        fix.sse *= self.extent.powi(4);
        fix.residuals.iter_mut().for_each(|residual| *residual *= self.extent);
        fix
    }
}
