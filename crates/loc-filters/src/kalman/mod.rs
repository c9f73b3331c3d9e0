//! The Kalman filter for linear systems, in one dimension (G1) and in many (G2).
//!
//! The belief is a Gaussian. Prediction moves it by the system's equation and widens it by the
//! noise; correction pulls it towards a measurement, as strongly as the two are trusted. A step
//! without a measurement is a prediction without a correction (G5).
//!
//! ```
//! use loc_filters::{Gate, ScalarKalmanFilter};
//! // G3: a robot stands still, two sensors measure its position.
//! let mut filter = ScalarKalmanFilter::new(0.0, 20.0)?;
//! filter.correct(1.0, 9.4, 0.25, &Gate::OPEN)?;
//! filter.correct(1.0, 10.6, 1.0, &Gate::OPEN)?;
//! assert!((filter.mean() - 9.5445545).abs() < 1e-7);
//! # Ok::<(), loc_filters::Error>(())
//! ```

pub mod rail;
pub(crate) mod update;

use crate::innovation::{Gate, Innovation, finite};
use crate::{Error, Result};
use loc_core::Gaussian;
use loc_core::error::{non_negative, positive};
use loc_core::gaussian::check_covariance;
use nalgebra::{Matrix1, SMatrix, SVector, Vector1};

/// A belief about one number, with its filter.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ScalarKalmanFilter {
    mean: f64,
    variance: f64,
}

impl ScalarKalmanFilter {
    /// A filter that starts from mean and variance.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a mean that is not finite or a negative variance.
    pub fn new(mean: f64, variance: f64) -> Result<Self> {
        let mean = loc_core::error::finite("mean", mean)?;
        Ok(ScalarKalmanFilter { mean, variance: non_negative("variance", variance)? })
    }

    /// The expected value.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Its variance.
    pub fn variance(&self) -> f64 {
        self.variance
    }

    /// Prediction: `mu- = a mu + b u`, `s-^2 = a^2 s^2 + s_eps^2`, with the process noise's
    /// variance `noise` = s_eps^2.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for numbers that are not finite, or a negative variance.
    pub fn predict(&mut self, a: f64, b: f64, u: f64, noise: f64) -> Result<()> {
        let mean = loc_core::error::finite("predicted mean", a * self.mean + b * u)?;
        let noise = non_negative("variance of the process noise", noise)?;
        self.variance = non_negative("predicted variance", a * a * self.variance + noise)?;
        self.mean = mean;
        Ok(())
    }

    /// Correction with a measurement `z = c x` of variance `noise` = s_delta^2:
    /// `k = c s^2/(c^2 s^2 + s_delta^2)`, `mu = mu + k (z - c mu)`, and the variance in Joseph's
    /// form of `s^2 = (1 - k c) s^2`.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the measurement, [`loc_core::Error::OutOfRange`] for a variance
    /// that is not positive.
    pub fn correct(&mut self, c: f64, z: f64, noise: f64, gate: &Gate) -> Result<Innovation<1>> {
        finite("measurement", &Vector1::new(z))?;
        let noise = positive("variance of the measurement", noise)?;
        let spread = c * c * self.variance + noise;
        let residual = Vector1::new(z - c * self.mean);
        let (innovation, _) = Innovation::new(residual, Matrix1::new(spread), gate)?;
        if innovation.accepted {
            let gain = c * self.variance / spread;
            let kept = 1.0 - gain * c;
            self.mean += gain * residual.x;
            self.variance = kept * kept * self.variance + gain * gain * noise;
        }
        Ok::<_, Error>(innovation)
    }
}

/// `x' = A x + B u + noise`: how a linear system of `N` states moves under `U` controls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearMotion<const N: usize, const U: usize> {
    a: SMatrix<f64, N, N>,
    b: SMatrix<f64, N, U>,
    noise: SMatrix<f64, N, N>,
}

/// `z = C x + noise`: what a sensor measures of a linear system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearMeasurement<const N: usize, const M: usize> {
    c: SMatrix<f64, M, N>,
    noise: SMatrix<f64, M, M>,
}

impl<const N: usize, const U: usize> LinearMotion<N, U> {
    /// A system from A (N x N), B (N x U), the covariance S_u of the control (U x U) and that of
    /// the process noise, R (N x N).
    ///
    /// # Errors
    /// [`loc_core::Error::NotACovariance`] for S_u and R, [`crate::Error::NotFinite`] for A and B.
    pub fn new(
        a: SMatrix<f64, N, N>,
        b: SMatrix<f64, N, U>,
        control_noise: SMatrix<f64, U, U>,
        process_noise: SMatrix<f64, N, N>,
    ) -> Result<Self> {
        for column in a.column_iter().chain(b.column_iter()) {
            finite("column of the system matrices", &column.into_owned())?;
        }
        check_covariance("covariance of the control", &control_noise)?;
        check_covariance("covariance of the process noise", &process_noise)?;
        Ok(LinearMotion { a, b, noise: b * control_noise * b.transpose() + process_noise })
    }

    /// How the state alone moves on, A (N x N).
    pub fn transition(&self) -> &SMatrix<f64, N, N> {
        &self.a
    }

    /// What a step adds to the covariance, `B S_u B^T + R` (N x N).
    pub fn noise(&self) -> &SMatrix<f64, N, N> {
        &self.noise
    }
}

impl<const N: usize, const M: usize> LinearMeasurement<N, M> {
    /// A sensor from C (M x N) and the covariance of its noise, Q (M x M).
    ///
    /// # Errors
    /// [`loc_core::Error::NotACovariance`] unless Q is positive definite.
    pub fn new(c: SMatrix<f64, M, N>, noise: SMatrix<f64, M, M>) -> Result<Self> {
        check_covariance("covariance of the measurement", &noise)?;
        loc_core::gaussian::cholesky("covariance of the measurement", &noise)?;
        Ok(LinearMeasurement { c, noise })
    }
}

/// A belief about `N` states, with its filter.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct KalmanFilter<const N: usize> {
    belief: Gaussian<N>,
}

impl<const N: usize> KalmanFilter<N> {
    /// A filter that starts from a belief.
    ///
    /// # Errors
    /// Those of [`Gaussian::new`].
    pub fn new(start: Gaussian<N>) -> Result<Self> {
        Ok(KalmanFilter { belief: Gaussian::new(start.mean, start.covariance)? })
    }

    /// The current belief.
    pub fn belief(&self) -> &Gaussian<N> {
        &self.belief
    }

    /// Prediction: `x- = A x + B u`, `S- = A S A^T + B S_u B^T + R`.
    ///
    /// # Errors
    /// [`crate::Error::NotFinite`] for the control.
    pub fn predict<const U: usize>(
        &mut self,
        motion: &LinearMotion<N, U>,
        u: &SVector<f64, U>,
    ) -> Result<()> {
        finite("control", u)?;
        self.belief.mean = motion.a * self.belief.mean + motion.b * u;
        self.belief.covariance =
            update::propagate(&motion.a, &self.belief.covariance, &motion.noise);
        Ok(())
    }

    /// Correction with a measurement `z`, unless the gate rejects it.
    ///
    /// # Errors
    /// [`crate::Error::NotFinite`] for the measurement.
    pub fn correct<const M: usize>(
        &mut self,
        sensor: &LinearMeasurement<N, M>,
        z: &SVector<f64, M>,
        gate: &Gate,
    ) -> Result<Innovation<M>> {
        finite("measurement", z)?;
        let residual = z - sensor.c * self.belief.mean;
        update::correct(&mut self.belief, residual, &sensor.c, &sensor.noise, gate)
    }
}
