//! The configuration of a simulated vehicle on a rail (G3, G4).

use crate::Result;
use crate::config::field;
use crate::localizer::RailSettings;
use loc_core::Gaussian;
use loc_core::error::{finite, non_negative, positive};
use nalgebra::{Matrix2, Vector2};
use serde::Deserialize;

/// A vehicle that accelerates along a straight line; its state is (position, speed).
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RailConfig {
    /// Duration of a step, T.
    pub time_step_s: f64,
    /// Number of steps.
    pub steps: usize,
    /// Commanded acceleration, u.
    #[serde(default)]
    pub acceleration_m_s2: f64,
    /// Standard deviation of the acceleration about the command.
    #[serde(default)]
    pub acceleration_sigma_m_s2: f64,
    /// Believed position at the start.
    #[serde(default)]
    pub position_m: f64,
    /// Its standard deviation.
    #[serde(default)]
    pub position_sigma_m: f64,
    /// Believed speed at the start.
    #[serde(default)]
    pub speed_m_s: f64,
    /// Its standard deviation.
    #[serde(default)]
    pub speed_sigma_m_s: f64,
    /// True position at the start; drawn from the belief where left out.
    pub true_position_m: Option<f64>,
    /// True speed at the start; drawn from the belief where left out.
    pub true_speed_m_s: Option<f64>,
    /// The position sensors.
    pub sensors: Vec<RailSensorConfig>,
}

/// A sensor of the position.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RailSensorConfig {
    /// Standard deviation of its readings.
    pub sigma_m: f64,
    /// Its readings, as pairs of step and position \[m\]; simulated at every step where left out.
    pub readings: Option<Vec<(usize, f64)>>,
}

impl RailConfig {
    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::Config`] and [`loc_core::Error::OutOfRange`] with the key.
    pub(crate) fn check(&self) -> Result<()> {
        positive("rail.time_step_s", self.time_step_s)?;
        if self.steps == 0 || self.steps > 100_000_000 {
            return Err(field("rail.steps", "1 to 100000000", &self.steps.to_string()));
        }
        finite("rail.acceleration_m_s2", self.acceleration_m_s2)?;
        non_negative("rail.acceleration_sigma_m_s2", self.acceleration_sigma_m_s2)?;
        non_negative("rail.position_sigma_m", self.position_sigma_m)?;
        non_negative("rail.speed_sigma_m_s", self.speed_sigma_m_s)?;
        for value in [self.true_position_m, self.true_speed_m_s].into_iter().flatten() {
            finite("rail.true_position_m, rail.true_speed_m_s", value)?;
        }
        for sensor in &self.sensors {
            positive("rail.sensors.sigma_m", sensor.sigma_m)?;
            for (step, position) in sensor.readings.iter().flatten() {
                finite("rail.sensors.readings: position [m]", *position)?;
                if *step > self.steps {
                    let expected = format!("steps from 0 to {}", self.steps);
                    return Err(field("rail.sensors.readings", &expected, &step.to_string()));
                }
            }
        }
        self.belief()?;
        Ok(())
    }

    /// The belief at the start.
    ///
    /// # Errors
    /// [`loc_core::Error`] for numbers that are not finite.
    pub(crate) fn belief(&self) -> Result<Gaussian<2>> {
        let variances = Vector2::new(self.position_sigma_m.powi(2), self.speed_sigma_m_s.powi(2));
        let mean = Vector2::new(self.position_m, self.speed_m_s);
        Ok(Gaussian::new(mean, Matrix2::from_diagonal(&variances))?)
    }

    /// What the filter is told.
    pub(crate) fn settings(&self) -> RailSettings {
        RailSettings {
            acceleration_sigma: self.acceleration_sigma_m_s2,
            sensor_sigmas: self.sensors.iter().map(|sensor| sensor.sigma_m).collect(),
        }
    }
}
