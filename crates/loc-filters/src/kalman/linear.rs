//! The Kalman filter in n dimensions (G2).

use super::update;
use crate::Result;
use crate::innovation::{Gate, Innovation, finite};
use loc_core::Gaussian;
use loc_core::gaussian::check_covariance;
use nalgebra::{SMatrix, SVector};

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
}

impl<const N: usize, const U: usize> LinearMotion<N, U> {
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

    /// What the filter believes now.
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

    /// Correction with a measurement `z`, unless the gate turns it away.
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
