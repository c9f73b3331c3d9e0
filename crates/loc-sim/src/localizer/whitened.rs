//! The innovation of one measurement, made comparable with all others.

use nalgebra::SVector;
use std::ops::Deref;

/// An innovation `L^-1 r` with `L L^T = S`: the residual r of a measurement in units of what its
/// covariance S promises. From an honest filter its numbers are independent of each other and of
/// all that came before, with mean 0 and variance 1.
///
/// A slice of at most [`Whitened::MAX`] numbers; empty for a method that computes none.
///
/// ```
/// use loc_sim::localizer::Whitened;
/// use nalgebra::Vector2;
/// let whitened = Whitened::from(Vector2::new(0.3, -1.2));
/// assert_eq!(*whitened, [0.3, -1.2]);
/// assert!(Whitened::NONE.is_empty());
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Whitened {
    values: [f64; Whitened::MAX],
    count: usize,
}

impl Whitened {
    /// The most numbers of one measurement that are kept.
    pub const MAX: usize = 3;
    /// No innovation.
    pub const NONE: Whitened = Whitened { values: [0.0; Whitened::MAX], count: 0 };
}

impl<const M: usize> From<SVector<f64, M>> for Whitened {
    /// Of a longer vector, the first numbers.
    fn from(vector: SVector<f64, M>) -> Self {
        let mut whitened = Whitened { count: M.min(Whitened::MAX), ..Whitened::NONE };
        for (value, given) in whitened.values.iter_mut().zip(vector.iter()) {
            *value = *given;
        }
        whitened
    }
}

impl Deref for Whitened {
    type Target = [f64];
    fn deref(&self) -> &[f64] {
        &self.values[..self.count]
    }
}
