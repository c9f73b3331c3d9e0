//! What became of a measurement.

use crate::Innovation;
use nalgebra::{SVector, Vector2};

/// The sensor that measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FusionSensor {
    /// Wheel odometry.
    Wheels,
    /// The inertial unit.
    Inertial,
    /// The compass.
    Compass,
    /// The satellite receiver.
    Position,
    /// The camera or the ranging radio, with the landmark's number.
    Landmark(u32),
}

/// What the filter made of one measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FusionOutcome {
    /// The sensor.
    pub sensor: FusionSensor,
    /// Whether it changed the belief.
    pub accepted: bool,
    /// Normalised innovation squared; `None` for a landmark that the map does not have.
    pub nis: Option<f64>,
    /// How many numbers were held against the expectation: 0, 1 or 2.
    pub degrees_of_freedom: usize,
    whitened: Vector2<f64>,
}

impl FusionOutcome {
    /// A measurement that nothing is expected of.
    pub(super) fn refused(sensor: FusionSensor) -> Self {
        let whitened = Vector2::zeros();
        FusionOutcome { sensor, accepted: false, nis: None, degrees_of_freedom: 0, whitened }
    }

    pub(super) fn of<const M: usize>(sensor: FusionSensor, innovation: &Innovation<M>) -> Self {
        let part = |vector: &SVector<f64, M>, k: usize| vector.get(k).copied().unwrap_or(0.0);
        FusionOutcome {
            sensor,
            accepted: innovation.accepted,
            nis: Some(innovation.nis),
            degrees_of_freedom: M.min(2),
            whitened: Vector2::from_fn(|k, _| part(&innovation.whitened, k)),
        }
    }

    /// The innovation in units of its standard deviations: as many independent numbers of variance
    /// 1 as there are degrees of freedom.
    pub fn whitened(&self) -> &[f64] {
        &self.whitened.as_slice()[..self.degrees_of_freedom.min(2)]
    }
}
