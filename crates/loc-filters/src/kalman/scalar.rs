//! The Kalman filter in one dimension (G1).

use crate::innovation::{Gate, Innovation, finite};
use crate::{Error, Result};
use loc_core::error::{non_negative, positive};
use nalgebra::{Matrix1, Vector1};

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
