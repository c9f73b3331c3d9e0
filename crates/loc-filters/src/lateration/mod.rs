//! Lateration (D1 to D4): the place at measured distances from landmarks.
//!
//! One distance puts the robot on a circle around a landmark, two where the circles cross, at one
//! of two points; three tell which. [`locate`] finds the place that fits any number of distances
//! best, in the plane or in space, with its covariance and everything that speaks against it:
//! a second place, circles that do not meet, a geometry that magnifies noise. [`two_circles`]
//! gives both points in closed form and [`newton`] the lectures' method with a start.
//! [`SlidingLateration`] follows a robot that measures one distance after the other, with the help
//! of its odometry.
//!
//! ```
//! use loc_filters::lateration::{LaterationSettings, Range, locate};
//! // Two landmarks see the robot at (3, 4) or at (3, -4); the third one decides.
//! let mut ranges = vec![Range::new([0.0, 0.0], 5.0, 0.1), Range::new([6.0, 0.0], 5.0, 0.1)];
//! let two = locate(&ranges, Some([3.0, 1.0].into()), &LaterationSettings::default())?;
//! assert!((two.best.position.y - 4.0).abs() < 1e-9 && !two.is_unique());
//! assert!((two.other.expect("the other side").position.y + 4.0).abs() < 1e-9);
//!
//! ranges.push(Range::new([3.0, 10.0], 6.1, 0.1));
//! let three = locate(&ranges, None, &LaterationSettings::default())?;
//! assert!((three.best.position.y - 3.9).abs() < 0.1 && three.is_unique());
//! # Ok::<(), loc_filters::Error>(())
//! ```
//!
//! # A sensor with a bias
//!
//! Radio ranges are often a few percent too long, or by a constant. With one range more for each,
//! scale and offset can be found beside the place ([`BiasPrior`]).

mod circles;
mod locate;
mod minimize;
mod sliding;

pub use circles::{Crossing, Miss, newton, two_circles};
pub use locate::locate;
pub use sliding::{SlidingLateration, SlidingSettings};

use crate::{Error, Result};
use loc_core::Gaussian;
use loc_core::error::{finite, in_range, non_negative, positive};
use nalgebra::{Point, SMatrix, SVector};

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

/// What a fix minimises.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Cost {
    /// `sum ((|x - l_i| - d_i) / sigma_i)^2`: the most likely place under normal errors.
    #[default]
    Distances,
    /// `sum (|x - l_i|^2 - d_i^2)^2`, the SSE of the lectures (D2). Long distances weigh more than
    /// they deserve.
    Squares,
}

/// How much a residual of `u` standard deviations costs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Loss {
    /// `u^2`: right where all errors are normal.
    #[default]
    Quadratic,
    /// Huber's: `u^2` up to the given number of standard deviations, linear beyond.
    Huber(f64),
    /// Cauchy's: `k^2 ln(1 + u^2 / k^2)`; far outliers hardly count, at the price of local minima.
    Cauchy(f64),
}

impl Loss {
    /// Checks where it bends.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] unless that is above 0.
    pub fn check(&self) -> loc_core::Result<()> {
        if let Loss::Huber(k) | Loss::Cauchy(k) = *self {
            positive("bend of the loss [standard deviations]", k)?;
        }
        Ok(())
    }

    /// Huber's loss with the bend at 1.345, which costs 5 % of the accuracy if all is normal
    /// (Holland and Welsch 1977).
    pub const HUBER: Loss = Loss::Huber(1.345);
    /// Cauchy's with 2.385, for the same 5 %.
    pub const CAUCHY: Loss = Loss::Cauchy(2.385);

    /// The loss of a residual of `u` standard deviations.
    pub fn cost(self, u: f64) -> f64 {
        match self {
            Loss::Quadratic => u * u,
            Loss::Huber(k) if u.abs() <= k => u * u,
            Loss::Huber(k) => k * (2.0 * u.abs() - k),
            Loss::Cauchy(k) => k * k * (u * u / (k * k)).ln_1p(),
        }
    }

    /// The weight of such a residual beside its weight in `u^2`, in (0, 1].
    pub fn weight(self, u: f64) -> f64 {
        match self {
            Loss::Quadratic => 1.0,
            Loss::Huber(k) => (k / u.abs()).min(1.0),
            Loss::Cauchy(k) => 1.0 / (1.0 + u * u / (k * k)),
        }
    }
}

/// How well the bias of the ranging sensor is known: standard deviations about scale 1 and offset
/// 0. One that is 0 is known, one that is infinite is an unknown like a coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct BiasPrior {
    /// Standard deviation of the scale.
    pub scale_sigma: f64,
    /// Standard deviation of the offset \[m\].
    pub offset_sigma: f64,
}

impl BiasPrior {
    /// The sensor is right.
    pub const KNOWN: BiasPrior = BiasPrior { scale_sigma: 0.0, offset_sigma: 0.0 };
    /// Nothing is known of its scale.
    pub const FREE_SCALE: BiasPrior = BiasPrior { scale_sigma: f64::INFINITY, offset_sigma: 0.0 };
    /// Nothing is known of its offset.
    pub const FREE_OFFSET: BiasPrior = BiasPrior { scale_sigma: 0.0, offset_sigma: f64::INFINITY };

    /// How many of the two have to be found from the ranges alone.
    fn free(&self) -> usize {
        [self.scale_sigma, self.offset_sigma].iter().filter(|sigma| sigma.is_infinite()).count()
    }

    /// Checks both.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for negative ones and NaN.
    pub fn check(&self) -> loc_core::Result<()> {
        let expected = "a number >= 0, infinity allowed";
        in_range("sigma of the range scale", expected, self.scale_sigma, |s| s >= 0.0)?;
        in_range("sigma of the range offset [m]", expected, self.offset_sigma, |s| s >= 0.0)?;
        Ok(())
    }
}

impl Default for BiasPrior {
    fn default() -> Self {
        BiasPrior::KNOWN
    }
}

/// Settings of lateration. The default is the most likely place under normal errors, of a
/// sensor without bias.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct LaterationSettings {
    /// What is minimised.
    pub cost: Cost,
    /// How much outliers cost.
    pub loss: Loss,
    /// What is known of the bias.
    pub bias: BiasPrior,
}

impl LaterationSettings {
    /// Checks every value.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub fn check(&self) -> loc_core::Result<()> {
        self.loss.check()?;
        self.bias.check()
    }
}

/// A place with all that is known about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Fix<const D: usize> {
    /// The place in the map \[m\].
    pub position: Point<f64, D>,
    /// Its covariance \[m^2\], D x D.
    pub covariance: SMatrix<f64, D, D>,
    /// The bias of the sensor: what was found, or what was known.
    pub bias: RangeBias,
    /// Standard deviations of scale and offset \[m\]; 0 for what was known.
    pub bias_sigmas: [f64; 2],
    /// The sum that was minimised. For [`Cost::Distances`] without outliers
    /// it is chi-square distributed, with as many degrees of freedom as ranges are left over.
    pub cost: f64,
    /// `sum (|x - l_i|^2 - d_i^2)^2` there \[m^4\], the SSE of D2.
    pub sse: f64,
    /// Of each range, measured minus expected \[m\].
    pub residuals: Vec<f64>,
    /// Of each range, how much of it the loss has let count, in (0, 1].
    pub weights: Vec<f64>,
    /// How the geometry magnifies noise.
    pub dilution: Dilution<D>,
}

impl<const D: usize> Fix<D> {
    /// The place as a belief.
    pub fn belief(&self) -> Gaussian<D> {
        Gaussian { mean: self.position.coords, covariance: self.covariance }
    }
}

/// The answer of [`locate`]: the best place, and what speaks against it.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution<const D: usize> {
    /// The place that fits best; of two that fit alike, the one nearer to the start.
    pub best: Fix<D>,
    /// The other place at which the cost has a minimum, mostly on the other side of the landmarks.
    pub other: Option<Fix<D>>,
    /// What to know before relying on it; empty is good.
    pub cautions: Vec<Caution>,
}

impl<const D: usize> Solution<D> {
    /// Whether the ranges alone say which of two places it is.
    pub fn is_unique(&self) -> bool {
        !self.cautions.iter().any(|caution| matches!(caution, Caution::Ambiguous { .. }))
    }
}

/// What speaks against a place.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Caution {
    /// The other place fits as well, up to noise (D1, D4).
    Ambiguous {
        /// By how much its cost is higher.
        margin: f64,
    },
    /// The circles (spheres) meet nowhere, as their noise would let them: the place is the one
    /// nearest to all of them.
    NoIntersection {
        /// The largest distance that is left to any of them \[m\].
        gap: f64,
        /// How improbable so large a gap is, as a chi-square of one degree of freedom.
        chi_square: f64,
    },
    /// The landmarks lie in nearly the same direction and magnify noise more than
    /// [`Caution::DILUTION`] times (D4).
    BadGeometry {
        /// The dilution of precision.
        dilution: f64,
    },
    /// Beyond what their noise explains, the ranges contradict each other.
    Contradiction {
        /// The sum of squared residuals, in standard deviations.
        chi_square: f64,
        /// How many ranges are left over.
        degrees_of_freedom: usize,
    },
}

impl Caution {
    /// The dilution of precision from which geometry counts as bad.
    pub const DILUTION: f64 = 6.0;
    /// Two costs that differ by less fit alike: three standard deviations.
    pub const MARGIN: f64 = 9.0;
}

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
            let offset = place - landmark;
            // At a landmark its range has no direction and says nothing to first order.
            let direction = offset.try_normalize(0.0).unwrap_or_else(SVector::zeros);
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
