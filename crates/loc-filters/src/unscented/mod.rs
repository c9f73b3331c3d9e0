//! The unscented Kalman filter (Julier and Uhlmann 1997): no derivatives, but points.
//!
//! Where a motion or a sensor bends, the tangent that the extended Kalman filter takes is wrong for
//! a belief that is wide. The unscented filter sends a few points of the belief, the sigma points,
//! through the model and takes mean and covariance of what comes out; up to the second order of the
//! bend that is right. It uses the same models as
//! [`ExtendedKalmanFilter`](crate::ExtendedKalmanFilter);
//! for linear ones the two are the same.
//!
//! The 2 N + 1 points stand in the mean and at `+- sqrt(N + kappa)` standard deviations, with
//! `kappa = 3 - N`, at least 0: no weight is negative, every covariance is a sum of squares. Angles
//! are averaged on the circle.
//!
//! ```
//! use loc_core::Gaussian;
//! use loc_filters::{Gate, MeasurementModel, UnscentedKalmanFilter};
//! use nalgebra::{Matrix1, Matrix1x2, Matrix2, Vector1, Vector2};
//!
//! /// Distance from the origin, measured to 0.1.
//! struct Distance;
//! impl MeasurementModel<2, 1> for Distance {
//!     fn predict(&self, x: &Vector2<f64>) -> Vector1<f64> { Vector1::new(x.norm()) }
//!     fn jacobian(&self, x: &Vector2<f64>) -> Matrix1x2<f64> { x.normalize().transpose() }
//!     fn noise(&self, _: &Vector1<f64>) -> Matrix1<f64> { Matrix1::new(0.01) }
//! }
//!
//! // Far off across the line of sight: the distance is longer than that of the mean.
//! let start = Gaussian::new(Vector2::new(3.0, 0.0), Matrix2::identity())?;
//! let mut filter = UnscentedKalmanFilter::new(start)?;
//! let innovation = filter.correct(&Distance, &Vector1::new(4.0), &Gate::OPEN)?;
//! assert!(innovation.residual.x < 0.9 && filter.belief().mean.x > 3.7);
//! # Ok::<(), loc_filters::Error>(())
//! ```

mod points;

use crate::angles::wrapped;
use crate::extended::{MeasurementModel, MotionModel};
use crate::innovation::{Gate, Innovation, finite};
use crate::kalman::update;
use crate::smoother::Link;
use crate::{Error, Result};
use loc_core::Gaussian;
use nalgebra::{SMatrix, SVector};
use points::{Points, factor};

/// A belief about `N` states, with its filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnscentedKalmanFilter<const N: usize> {
    belief: Gaussian<N>,
    angles: &'static [usize],
    steps: u64,
}

/// What a prediction did with the sigma points.
pub(crate) struct Followed<const N: usize> {
    off: Points<SVector<f64, N>, N>,
    root: SMatrix<f64, N, N>,
    noise: SMatrix<f64, N, N>,
}

impl<const N: usize> Followed<N> {
    /// How the states before and after hang together.
    pub(crate) fn link(&self) -> Link<N> {
        let (slopes, bend) = self.off.slopes_and_bend();
        Link::Points { root: self.root, slopes, noise: self.noise + bend }
    }
}

impl<const N: usize> UnscentedKalmanFilter<N> {
    /// A filter that starts from a belief.
    ///
    /// # Errors
    /// Those of [`Gaussian::new`].
    pub fn new(start: Gaussian<N>) -> Result<Self> {
        let belief = Gaussian::new(start.mean, start.covariance)?;
        Ok(UnscentedKalmanFilter { belief, angles: &[], steps: 0 })
    }

    /// Names the states that are angles, to be kept in (-pi, pi]; indices beyond the state are
    /// passed over.
    #[must_use]
    pub fn with_angles(mut self, angles: &'static [usize]) -> Self {
        self.angles = angles;
        self.belief.mean = self.wrapped(self.belief.mean);
        self
    }

    /// What the filter believes now.
    pub fn belief(&self) -> &Gaussian<N> {
        &self.belief
    }

    /// The states that are angles.
    pub(crate) fn angles(&self) -> &'static [usize] {
        self.angles
    }

    /// Prediction: mean and covariance of the moved sigma points, plus the noise that the model
    /// has at the mean.
    ///
    /// # Errors
    /// [`Error::NotFinite`] where the model leads to NaN or infinity, [`Error::LostPositivity`]
    /// where the covariance is none any more; the belief is kept.
    pub fn predict(&mut self, motion: &impl MotionModel<N>) -> Result<()> {
        self.follow(motion).map(|_| ())
    }

    /// Prediction; the answer are the moved points, about their mean, the root of the covariance that
    /// they stood along, and the noise of the motion.
    pub(crate) fn follow(&mut self, motion: &impl MotionModel<N>) -> Result<Followed<N>> {
        let (points, root) = self.points()?;
        let moved = points.map(|state| motion.predict(state));
        moved.iter().try_for_each(|state| finite("predicted state", state))?;
        let mean = moved.mean(|state, center| self.wrapped(state - center));
        let off = moved.map(|state| self.wrapped(state - mean));
        let noise = motion.linearize(&self.belief.mean).noise;
        let covariance = off.second_moment() + noise;
        if !covariance.iter().all(|value| value.is_finite()) {
            let found = format!("{:?}", covariance.as_slice());
            return Err(Error::NotFinite { what: "predicted covariance", found });
        }
        self.belief = Gaussian { mean: self.wrapped(mean), covariance };
        self.steps += 1;
        Ok(Followed { off, root, noise })
    }

    /// Correction with a measurement `z`, unless the gate turns it away.
    ///
    /// With the square root L of the covariance and the sigma points' measurements, the state in
    /// units of L is measured through a matrix G^T, and what the points deviate from a line is
    /// noise beside that of the sensor. The correction is then Joseph's, in these units; it equals
    /// the textbook's `P - K S K^T` and cannot become negative.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the measurement or what the model expects,
    /// [`Error::LostPositivity`] for a covariance that is none any more, and
    /// [`loc_core::Error::NotACovariance`] for that of the innovation; the belief is kept.
    // ANCHOR: correct
    pub fn correct<const M: usize>(
        &mut self,
        sensor: &impl MeasurementModel<N, M>,
        z: &SVector<f64, M>,
        gate: &Gate,
    ) -> Result<Innovation<M>> {
        finite("measurement", z)?;
        let (points, root) = self.points()?;
        let seen = points.map(|state| sensor.predict(state));
        seen.iter().try_for_each(|seen| finite("expected measurement", seen))?;
        let expected = seen.mean(|seen, center| sensor.residual(seen, center));
        let off = seen.map(|seen| sensor.residual(seen, &expected));
        let (gain, bend) = off.slopes_and_bend();
        let noise = sensor.noise(&expected) + bend;
        let residual = sensor.residual(z, &expected);
        let mut unit = Gaussian { mean: SVector::zeros(), covariance: SMatrix::identity() };
        let innovation = update::correct(&mut unit, residual, &gain, &noise, gate)?;
        if innovation.accepted {
            let mean = self.wrapped(self.belief.mean + root * unit.mean);
            let covariance = update::propagate(&root, &unit.covariance, &SMatrix::zeros());
            self.belief = Gaussian { mean, covariance };
        }
        self.steps += 1;
        Ok(innovation)
    }
    // ANCHOR_END: correct

    /// The sigma points, and the square root L of the covariance that they stand along.
    fn points(&self) -> Result<(Points<SVector<f64, N>, N>, SMatrix<f64, N, N>)> {
        let root = factor(&self.belief.covariance).ok_or_else(|| Error::LostPositivity {
            what: "covariance of an unscented filter",
            step: self.steps,
            found: format!("{:?}", self.belief.covariance.as_slice()),
        })?;
        Ok((Points::about(&self.belief.mean, &root), root))
    }

    fn wrapped(&self, state: SVector<f64, N>) -> SVector<f64, N> {
        wrapped(state, self.angles)
    }
}
