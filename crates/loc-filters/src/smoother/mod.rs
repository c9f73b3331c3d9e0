//! Smoothing: what the whole drive says about each moment (Rauch, Tung and Striebel 1965).
//!
//! A filter knows the past of each moment, not its future: a landmark seen now also says where the
//! robot was a second ago. Once a drive is over, the smoother walks back through the filter's
//! beliefs and takes to each what those after it have learnt. The smoothed beliefs of a linear
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

mod gain;
mod recorded;

pub use recorded::{Recordable, Recorded};

use crate::extended::LinearizedMotion;
use crate::kalman::update::propagate;
use crate::{Error, Result};
use loc_core::{Gaussian, angle};
use nalgebra::SMatrix;

/// The beliefs of a filter over a drive, with what led from each to the next.
#[derive(Debug, Clone, PartialEq)]
pub struct Smoother<const N: usize> {
    angles: &'static [usize],
    nodes: Vec<Node<N>>,
}

/// A moment between two predictions.
#[derive(Debug, Clone, PartialEq)]
struct Node<const N: usize> {
    /// The belief after all corrections of this moment.
    filtered: Gaussian<N>,
    /// How it was reached; `None` at the start.
    step: Option<Step<N>>,
}

/// A prediction.
#[derive(Debug, Clone, PartialEq)]
struct Step<const N: usize> {
    /// The belief that it led to, before any correction.
    predicted: Gaussian<N>,
    link: Link<N>,
}

/// How the state before a prediction and the one after it hang together.
#[derive(Debug, Clone, PartialEq)]
enum Link<const N: usize> {
    /// By a linearised motion: F and Q.
    Linear { jacobian: SMatrix<f64, N, N>, noise: SMatrix<f64, N, N> },
    /// By the covariance of the two.
    Cross(SMatrix<f64, N, N>),
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
        Smoother { angles, nodes: vec![Node { filtered, step: None }] }
    }

    /// Names the states that are angles, to be kept in (-pi, pi].
    #[must_use]
    pub fn with_angles(mut self, angles: &'static [usize]) -> Self {
        self.angles = angles;
        self
    }

    /// Takes in a prediction by the linearised motion `F`, `Q` that led to the belief `predicted`.
    /// This opens a new moment.
    pub fn predicted(&mut self, motion: &LinearizedMotion<N>, predicted: &Gaussian<N>) {
        let link = Link::Linear { jacobian: motion.jacobian, noise: motion.noise };
        self.open(link, predicted);
    }

    /// Takes in a prediction of which only the covariance of the states before (rows) and after
    /// (columns) is known, as an unscented filter has it.
    pub fn predicted_with_cross_covariance(
        &mut self,
        cross: &SMatrix<f64, N, N>,
        predicted: &Gaussian<N>,
    ) {
        self.open(Link::Cross(*cross), predicted);
    }

    fn open(&mut self, link: Link<N>, predicted: &Gaussian<N>) {
        let step = Some(Step { predicted: *predicted, link });
        self.nodes.push(Node { filtered: *predicted, step });
    }

    /// Takes in the belief after a correction; of several at one moment the last one counts.
    pub fn corrected(&mut self, belief: &Gaussian<N>) {
        if let Some(node) = self.nodes.last_mut() {
            node.filtered = *belief;
        }
    }

    /// How many moments there are: the start, and one per prediction.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether there is nothing but the start.
    pub fn is_empty(&self) -> bool {
        self.nodes.len() <= 1
    }

    /// What the filter believed at a moment, after its corrections.
    pub fn filtered(&self, moment: usize) -> Option<&Gaussian<N>> {
        self.nodes.get(moment).map(|node| &node.filtered)
    }

    /// The smoothed beliefs, one per moment; the last one is the filter's own.
    ///
    /// With `C = P F^T (P-)^-1`: mean `x + C (x_s - x-)`, covariance
    /// `(I - C F) P (I - C F)^T + C (Q + P_s) C^T`, a sum of squares, which stays symmetric and
    /// positive where the textbook's `P + C (P_s - P-) C^T` need not (x-, P- are the prediction
    /// after the moment, x_s, P_s what was smoothed there). Directions that a prediction was certain
    /// of are left as they are.
    ///
    /// # Errors
    /// [`Error::NotFinite`] and [`loc_core::Error::NotACovariance`] for beliefs that are none.
    pub fn smooth(&self) -> Result<Vec<Gaussian<N>>> {
        let mut backwards: Vec<Gaussian<N>> = Vec::with_capacity(self.nodes.len());
        let mut after: Option<(&Step<N>, Gaussian<N>)> = None;
        for (moment, node) in self.nodes.iter().enumerate().rev() {
            let smoothed = match &after {
                None => node.filtered,
                Some((step, later)) => self.step_back(&node.filtered, step, later)?,
            };
            if !smoothed.mean.iter().chain(smoothed.covariance.iter()).all(|v| v.is_finite()) {
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
            Link::Linear { jacobian, .. } => p * jacobian.transpose(),
            Link::Cross(cross) => *cross,
        };
        let gain = gain::gain(&cross, &step.predicted.covariance)?;
        let mut change = later.mean - step.predicted.mean;
        for &index in self.angles {
            if let Some(value) = change.get_mut(index) {
                *value = angle::wrap(*value);
            }
        }
        let mut mean = filtered.mean + gain * change;
        for &index in self.angles {
            if let Some(value) = mean.get_mut(index) {
                *value = angle::wrap(*value);
            }
        }
        let covariance = match &step.link {
            Link::Linear { jacobian, noise } => {
                let kept = SMatrix::identity() - gain * jacobian;
                let learnt = propagate(&gain, &(noise + later.covariance), &SMatrix::zeros());
                propagate(&kept, p, &learnt)
            }
            Link::Cross(_) => {
                let known = step.predicted.covariance - later.covariance;
                let change = propagate(&gain, &known, &SMatrix::zeros());
                symmetric(&(p - change))
            }
        };
        Ok(Gaussian { mean, covariance })
    }
    // ANCHOR_END: step-back
}

fn symmetric<const N: usize>(matrix: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    0.5 * (matrix + matrix.transpose())
}
