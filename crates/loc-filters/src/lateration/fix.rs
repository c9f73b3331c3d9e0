//! What lateration answers.

use super::{Dilution, RangeBias};
use loc_core::Gaussian;
use nalgebra::{Point, SMatrix};

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
    /// The sum that was minimised. For [`Cost::Distances`](super::Cost::Distances) without outliers
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

/// The answer of [`locate`](super::locate): the best place, and what speaks against it.
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
