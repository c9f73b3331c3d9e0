//! The extended Kalman filter (H1): the Kalman filter of nonlinear systems.
//!
//! A user provides two models with their derivatives: how the state moves, and what a sensor measures of
//! it. The filter linearises them at its estimate.
//!
//! ```
//! use loc_core::Gaussian;
//! use loc_filters::{ExtendedKalmanFilter, Gate, MeasurementModel};
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
//! let start = Gaussian::new(Vector2::new(3.0, 0.0), Matrix2::identity())?;
//! let mut filter = ExtendedKalmanFilter::new(start)?;
//! let innovation = filter.correct(&Distance, &Vector1::new(4.0), &Gate::OPEN)?;
//! assert!(innovation.accepted && filter.belief().mean.x > 3.9);
//! # Ok::<(), loc_filters::Error>(())
//! ```

use crate::Result;
use crate::innovation::{Gate, Innovation, finite};
use crate::kalman::update;
use crate::kalman::update::wrapped;
use loc_core::Gaussian;
use nalgebra::{SMatrix, SVector};

/// A motion, linearised at a state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearizedMotion<const N: usize> {
    /// The state that it leads to, `g(x, u)`.
    pub state: SVector<f64, N>,
    /// Its derivative over the state, `G_x`, N x N.
    pub jacobian: SMatrix<f64, N, N>,
    /// The noise that it adds, `G_u S_u G_u^T + R`, N x N.
    pub noise: SMatrix<f64, N, N>,
}

/// How the state moves in one step, control included.
pub trait MotionModel<const N: usize> {
    /// The state after the step, `g(x, u)`.
    fn predict(&self, state: &SVector<f64, N>) -> SVector<f64, N>;
    /// The same with derivative and noise.
    fn linearize(&self, state: &SVector<f64, N>) -> LinearizedMotion<N>;
}

/// What a sensor sees of the state.
pub trait MeasurementModel<const N: usize, const M: usize> {
    /// The measurement that is expected, `h(x)`.
    fn predict(&self, state: &SVector<f64, N>) -> SVector<f64, M>;
    /// Its derivative over the state, `H`, M x N.
    fn jacobian(&self, state: &SVector<f64, N>) -> SMatrix<f64, M, N>;
    /// Both at once; worth overriding where they share their work.
    fn linearize(&self, state: &SVector<f64, N>) -> (SVector<f64, M>, SMatrix<f64, M, N>) {
        (self.predict(state), self.jacobian(state))
    }
    /// Covariance of the sensor's noise, `Q`, where it is expected to measure `expected`.
    fn noise(&self, expected: &SVector<f64, M>) -> SMatrix<f64, M, M>;
    /// Measurement minus expectation; a model of angles wraps them here.
    fn residual(&self, z: &SVector<f64, M>, expected: &SVector<f64, M>) -> SVector<f64, M> {
        z - expected
    }
}

/// A belief about `N` states, with its filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtendedKalmanFilter<const N: usize> {
    belief: Gaussian<N>,
    angles: &'static [usize],
}

impl<const N: usize> ExtendedKalmanFilter<N> {
    /// A filter that starts from a belief.
    ///
    /// # Errors
    /// Those of [`Gaussian::new`].
    pub fn new(start: Gaussian<N>) -> Result<Self> {
        let belief = Gaussian::new(start.mean, start.covariance)?;
        Ok(ExtendedKalmanFilter { belief, angles: &[] })
    }

    /// Names the states that are angles, to be kept in (-pi, pi]; indices beyond the state are
    /// passed over.
    #[must_use]
    pub fn with_angles(mut self, angles: &'static [usize]) -> Self {
        self.angles = angles;
        self.wrap_angles();
        self
    }

    /// The current belief.
    pub fn belief(&self) -> &Gaussian<N> {
        &self.belief
    }

    /// The states that are angles.
    pub(crate) fn angles(&self) -> &'static [usize] {
        self.angles
    }

    /// Prediction: `x- = g(x, u)`, `S- = G_x S G_x^T + G_u S_u G_u^T + R`.
    ///
    /// # Errors
    /// [`crate::Error::NotFinite`] where the model leads to NaN or infinity; the belief is kept.
    pub fn predict(&mut self, motion: &impl MotionModel<N>) -> Result<()> {
        let linear = motion.linearize(&self.belief.mean);
        self.predict_linearized(&linear)
    }

    /// Prediction by a motion that is linearised already.
    pub(crate) fn predict_linearized(&mut self, motion: &LinearizedMotion<N>) -> Result<()> {
        finite("predicted state", &motion.state)?;
        let (jacobian, noise) = (&motion.jacobian, &motion.noise);
        self.belief.mean = motion.state;
        self.belief.covariance = update::propagate(jacobian, &self.belief.covariance, noise);
        self.wrap_angles();
        Ok(())
    }

    /// Correction with a measurement `z`, unless the gate rejects it.
    ///
    /// # Errors
    /// [`crate::Error::NotFinite`] for the measurement, and [`loc_core::Error::NotACovariance`]
    /// where the innovation's covariance is not positive definite; the belief is kept.
    // ANCHOR: correct
    pub fn correct<const M: usize>(
        &mut self,
        sensor: &impl MeasurementModel<N, M>,
        z: &SVector<f64, M>,
        gate: &Gate,
    ) -> Result<Innovation<M>> {
        finite("measurement", z)?;
        let (expected, h) = sensor.linearize(&self.belief.mean);
        let residual = sensor.residual(z, &expected);
        let q = sensor.noise(&expected);
        let innovation = update::correct(&mut self.belief, residual, &h, &q, gate)?;
        self.wrap_angles();
        Ok(innovation)
    }
    // ANCHOR_END: correct

    fn wrap_angles(&mut self) {
        self.belief.mean = wrapped(self.belief.mean, self.angles);
    }
}
