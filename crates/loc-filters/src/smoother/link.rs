//! What the smoother needs to know of a filter: its belief, its angles, and how it came from one
//! moment to the next.

use loc_core::Gaussian;
use nalgebra::SMatrix;

/// A filter that [`Recorded`](super::Recorded) can keep the past of.
pub trait Recordable<const N: usize> {
    /// What the filter believes now.
    fn belief(&self) -> &Gaussian<N>;
    /// The states that are angles.
    fn angles(&self) -> &'static [usize];
}

/// How the state before a prediction and the one after it hang together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Link<const N: usize> {
    /// By a tangent: the state after is `F x` and noise.
    Tangent {
        /// F.
        jacobian: SMatrix<f64, N, N>,
        /// Its covariance.
        noise: SMatrix<f64, N, N>,
    },
    /// By sigma points: `x = mean + L u` before, `A u` and noise after, with u of covariance 1.
    Points {
        /// L, with `L L^T` the covariance before.
        root: SMatrix<f64, N, N>,
        /// A.
        slopes: SMatrix<f64, N, N>,
        /// The noise of the motion, and what the points leave over from a line.
        noise: SMatrix<f64, N, N>,
    },
}
