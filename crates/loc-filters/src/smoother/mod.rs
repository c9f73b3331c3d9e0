//! Smoothing: the belief of each moment from all measurements (Rauch, Tung and Striebel 1965).
//!
//! A filter uses the past of each moment, not its future: a landmark observed now also determines where
//! the robot was a second ago. At the end of a recording the smoother runs backwards through the
//! filter's beliefs and corrects each by those after it. The smoothed beliefs of a linear
//! system are exactly those that least squares over all measurements at once gives.
//!
//! A filter is wrapped in [`Recorded`], run as always, and smoothed at the end; other filters hand
//! their beliefs to a [`Smoother`] themselves.
//!
//! ```
//! use loc_core::Gaussian;
//! use loc_filters::kalman::{KalmanFilter, LinearMeasurement, LinearMotion};
//! use loc_filters::{Gate, smoother::Recorded};
//! use nalgebra::{Matrix1, Vector1};
//! // A robot that stands still, and two measurements of where: at the start nothing was known.
//! let still = LinearMotion::new(
//!     Matrix1::new(1.0), Matrix1::new(0.0), Matrix1::new(0.0), Matrix1::new(0.0),
//! )?;
//! let sensor = LinearMeasurement::new(Matrix1::new(1.0), Matrix1::new(1.0))?;
//! let start = Gaussian::new(Vector1::new(0.0), Matrix1::new(1e6))?;
//! let mut filter = Recorded::new(KalmanFilter::new(start)?);
//! for z in [4.0, 6.0] {
//!     filter.predict(&still, &Vector1::new(0.0))?;
//!     filter.correct(&sensor, &Vector1::new(z), &Gate::OPEN)?;
//! }
//! let smoothed = filter.past().smooth()?;
//! assert!((smoothed[1].mean.x - 5.0).abs() < 1e-4, "the second measurement is known at the first");
//! # Ok::<(), loc_filters::Error>(())
//! ```

mod recorded;

pub use recorded::{Recorded, Smoothable, smooth};

use crate::extended::LinearizedMotion;
use crate::innovation::Factor;
use crate::kalman::update::{propagate, wrapped};
use crate::{Error, Result};
use loc_core::Gaussian;
use nalgebra::{DMatrix, SMatrix, SVector};
use std::fmt;
use std::sync::Arc;

/// The beliefs of a filter over a drive, with what led from each to the next. A copy of it is cheap.
#[derive(Debug, Clone)]
pub struct Smoother<const N: usize> {
    angles: &'static [usize],
    past: Chain<Node<N>>,
    now: Node<N>,
}

/// A moment between two predictions.
#[derive(Debug, Clone)]
struct Node<const N: usize> {
    /// The belief after all corrections of this moment.
    filtered: Gaussian<N>,
    /// How it was reached; `None` at the start.
    step: Option<Step<N>>,
    /// Number of marks.
    marks: usize,
}

/// A prediction.
#[derive(Debug, Clone, Copy)]
struct Step<const N: usize> {
    /// The belief that it led to, before any correction.
    predicted: Gaussian<N>,
    link: Link<N>,
}

impl<const N: usize> Smoother<N> {
    /// Begins with the belief at the start.
    ///
    /// # Errors
    /// Those of [`Gaussian::new`].
    pub fn new(start: Gaussian<N>) -> Result<Self> {
        Ok(Smoother::begin(Gaussian::new(start.mean, start.covariance)?, &[]))
    }

    /// Begins with a belief that is known to be one.
    fn begin(filtered: Gaussian<N>, angles: &'static [usize]) -> Self {
        let now = Node { filtered, step: None, marks: 0 };
        Smoother { angles, past: Chain::EMPTY, now }
    }

    /// Names the states that are angles, to be kept in (-pi, pi].
    #[must_use]
    pub fn with_angles(mut self, angles: &'static [usize]) -> Self {
        self.angles = angles;
        self
    }

    /// Records a prediction by the linearised motion `F`, `Q` that led to the belief `predicted`.
    /// This opens a new moment.
    pub fn predicted(&mut self, motion: &LinearizedMotion<N>, predicted: &Gaussian<N>) {
        let link = Link::Tangent { jacobian: motion.jacobian, noise: motion.noise };
        self.linked(link, predicted);
    }

    /// Records a prediction that led to the belief `predicted`, by what links it to the one before.
    /// This opens a new moment.
    pub fn linked(&mut self, link: Link<N>, predicted: &Gaussian<N>) {
        let step = Some(Step { predicted: *predicted, link });
        let next = Node { filtered: *predicted, step, marks: 0 };
        self.past.push(std::mem::replace(&mut self.now, next));
    }

    /// Records the belief after a correction; of several at one moment the last one counts.
    pub fn corrected(&mut self, belief: &Gaussian<N>) {
        self.now.filtered = *belief;
    }

    /// Marks the belief of this moment, see [`smooth_marked`](Smoother::smooth_marked).
    pub fn mark(&mut self) {
        self.now.marks += 1;
    }

    /// How many moments there are: the start, and one per prediction.
    pub fn len(&self) -> usize {
        self.past.len() + 1
    }

    /// Whether there is nothing but the start.
    pub fn is_empty(&self) -> bool {
        self.past.len() == 0
    }

    /// The moments, the last one first.
    fn backwards(&self) -> impl Iterator<Item = &Node<N>> {
        std::iter::once(&self.now).chain(self.past.backwards())
    }

    /// The filtered belief at each mark, after the corrections of the moment.
    pub fn filtered_marked(&self) -> Vec<Gaussian<N>> {
        let mut marked: Vec<Gaussian<N>> = Vec::new();
        for node in self.backwards() {
            marked.extend(std::iter::repeat_n(node.filtered, node.marks));
        }
        marked.reverse();
        marked
    }

    /// The smoothed belief of each mark, in the order of the marks.
    ///
    /// # Errors
    /// Those of [`Smoother::smooth`].
    pub fn smooth_marked(&self) -> Result<Vec<Gaussian<N>>> {
        let smoothed = self.smooth()?;
        let mut marked: Vec<Gaussian<N>> = Vec::new();
        for (node, belief) in self.backwards().zip(smoothed.iter().rev()) {
            marked.extend(std::iter::repeat_n(*belief, node.marks));
        }
        marked.reverse();
        Ok(marked)
    }

    /// The smoothed beliefs, one per moment; the last one is the filter's own.
    ///
    /// With `C = P F^T (P-)^-1`: mean `x + C (x_s - x-)`, covariance
    /// `(I - C F) P (I - C F)^T + C (Q + P_s) C^T`, a sum of squares, which stays symmetric and
    /// positive where the textbook's `P + C (P_s - P-) C^T` need not (x-, P- are the prediction
    /// after the moment, x_s, P_s what was smoothed there). Of sigma points, the slopes A along the
    /// root L take the place of `F L`. Directions that a prediction was certain of are left as they
    /// are.
    ///
    /// # Errors
    /// [`Error::NotFinite`] and [`loc_core::Error::NotACovariance`] for beliefs that are none.
    pub fn smooth(&self) -> Result<Vec<Gaussian<N>>> {
        let mut backwards: Vec<Gaussian<N>> = Vec::with_capacity(self.len());
        let mut after: Option<(&Step<N>, Gaussian<N>)> = None;
        for node in self.backwards() {
            let smoothed = match &after {
                None => node.filtered,
                Some((step, later)) => self.step_back(&node.filtered, step, later)?,
            };
            if !smoothed.mean.iter().chain(smoothed.covariance.iter()).all(|v| v.is_finite()) {
                let moment = self.len() - 1 - backwards.len();
                let found = format!("{:?} at step {moment}", smoothed.mean.as_slice());
                return Err(Error::NotFinite { what: "smoothed state", found });
            }
            backwards.push(smoothed);
            match &node.step {
                Some(step) => after = Some((step, smoothed)),
                None => break,
            }
        }
        backwards.reverse();
        Ok(backwards)
    }

    // ANCHOR: step-back
    fn step_back(
        &self,
        filtered: &Gaussian<N>,
        step: &Step<N>,
        later: &Gaussian<N>,
    ) -> Result<Gaussian<N>> {
        let p = &filtered.covariance;
        let cross = match &step.link {
            Link::Tangent { jacobian, .. } => p * jacobian.transpose(),
            Link::Points { root, slopes, .. } => root * slopes.transpose(),
        };
        let gain = gain(&cross, &step.predicted.covariance)?;
        let change = self.wrapped(later.mean - step.predicted.mean);
        let mean = self.wrapped(filtered.mean + gain * change);
        let (noise, kept, before) = match &step.link {
            Link::Tangent { jacobian, noise } => (noise, SMatrix::identity() - gain * jacobian, *p),
            Link::Points { root, slopes, noise } => {
                (noise, root - gain * slopes, SMatrix::identity())
            }
        };
        let learnt = propagate(&gain, &(noise + later.covariance), &SMatrix::zeros());
        let covariance = propagate(&kept, &before, &learnt);
        Ok(Gaussian { mean, covariance })
    }
    // ANCHOR_END: step-back

    fn wrapped(&self, state: SVector<f64, N>) -> SVector<f64, N> {
        wrapped(state, self.angles)
    }
}

/// A filter that [`Recorded`] can keep the past of.
pub trait Recordable<const N: usize> {
    /// The current belief.
    fn belief(&self) -> &Gaussian<N>;
    /// The states that are angles.
    fn angles(&self) -> &'static [usize];
}

/// How the states before and after a prediction are related.
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

/// Directions whose variance is smaller than this share of that of the coordinates, are certain.
const CERTAIN: f64 = 1e-12;

/// `cross P^-1`, where `P` is positive definite; else with its pseudo-inverse.
///
/// What is certain after a prediction cannot be learnt better, so nothing flows back from there.
fn gain<const N: usize>(
    cross: &SMatrix<f64, N, N>,
    p: &SMatrix<f64, N, N>,
) -> Result<SMatrix<f64, N, N>> {
    if !p.iter().chain(cross.iter()).all(|value| value.is_finite()) {
        return Err(loc_core::Error::NotACovariance {
            what: "covariance of a prediction",
            expected: "symmetric positive semi-definite",
            found: format!("{p:?}"),
        }
        .into());
    }
    // In units of the standard deviations, so that metres and radians compare.
    let sigma: [f64; N] = std::array::from_fn(|i| p[(i, i)].max(0.0).sqrt());
    let per_sigma = sigma.map(|sigma| if sigma > 0.0 { 1.0 / sigma } else { 0.0 });
    let correlation = SMatrix::<f64, N, N>::from_fn(|i, j| {
        if i == j { 1.0 } else { p[(i, j)] * per_sigma[i] * per_sigma[j] }
    });
    let scaled = SMatrix::<f64, N, N>::from_fn(|i, j| cross[(i, j)] * per_sigma[j]);
    let solved = match Factor::new(&correlation) {
        Ok(factor) => factor.solve_right(scaled),
        Err(_) => scaled * pseudo_inverse(&correlation),
    };
    Ok(SMatrix::from_fn(|i, j| solved[(i, j)] * per_sigma[j]))
}

/// Inverts a symmetric matrix in the directions in which it is not nearly 0.
fn pseudo_inverse<const N: usize>(matrix: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    let whole = DMatrix::from_fn(N, N, |i, j| 0.5 * (matrix[(i, j)] + matrix[(j, i)]));
    let eigen = whole.symmetric_eigen();
    let inverse = eigen.eigenvalues.map(|value| if value > CERTAIN { 1.0 / value } else { 0.0 });
    let vectors = &eigen.eigenvectors;
    let product = vectors * DMatrix::from_diagonal(&inverse) * vectors.transpose();
    SMatrix::from_fn(|i, j| product[(i, j)])
}

/// Values in the order in which they were pushed.
///
/// Filters are copied often: to try a correction, or to keep the state before an input that may be
/// followed by a late one. A copy of a chain takes constant time, whatever its length.
struct Chain<T> {
    last: Option<Arc<Entry<T>>>,
    len: usize,
}

struct Entry<T> {
    value: T,
    before: Option<Arc<Entry<T>>>,
}

impl<T> Chain<T> {
    const EMPTY: Self = Chain { last: None, len: 0 };

    fn push(&mut self, value: T) {
        let before = self.last.take();
        self.last = Some(Arc::new(Entry { value, before }));
        self.len += 1;
    }

    fn len(&self) -> usize {
        self.len
    }

    /// The values, the last one first.
    fn backwards(&self) -> impl Iterator<Item = &T> {
        let entries = std::iter::successors(self.last.as_deref(), |entry| entry.before.as_deref());
        entries.map(|entry| &entry.value)
    }
}

impl<T> Clone for Chain<T> {
    fn clone(&self) -> Self {
        Chain { last: self.last.clone(), len: self.len }
    }
}

/// One entry after the other: left to the compiler, a long chain would overflow the stack.
impl<T> Drop for Chain<T> {
    fn drop(&mut self) {
        let mut next = self.last.take();
        while let Some(mut entry) = next.and_then(Arc::into_inner) {
            next = entry.before.take();
        }
    }
}

impl<T> fmt::Debug for Chain<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} moments", self.len)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_share_what_was_before_and_go_their_own_way() {
        let mut one = Chain::EMPTY;
        one.push(1);
        one.push(2);
        let mut other = one.clone();
        one.push(3);
        other.push(4);
        assert_eq!(one.backwards().copied().collect::<Vec<_>>(), [3, 2, 1]);
        assert_eq!(other.backwards().copied().collect::<Vec<_>>(), [4, 2, 1]);
        drop(one);
        assert_eq!(other.backwards().copied().collect::<Vec<_>>(), [4, 2, 1]);
        assert_eq!(other.len(), 3);
    }

    #[test]
    fn a_long_past_is_forgotten_without_trouble() {
        let mut chain = Chain::EMPTY;
        (0..1_000_000).for_each(|k| chain.push(k));
        let copy = chain.clone();
        drop(chain);
        assert_eq!(copy.backwards().count(), 1_000_000);
    }
}
