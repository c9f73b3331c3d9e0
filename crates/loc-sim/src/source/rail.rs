//! A simulated vehicle on a rail (G3, G4).

use super::{Setup, Source};
use crate::Result;
use crate::config::field;
use loc_core::error::{finite, non_negative, positive};
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Gaussian, Pose2};
use loc_filters::kalman::rail::RailSettings;
use loc_sensors::event::{Control, Event, Measurement, Payload, Truth};
use nalgebra::{Matrix2, Vector2, Vector3};
use rand_distr::{Distribution, StandardNormal};
use serde::Deserialize;
use std::collections::VecDeque;

/// A vehicle in simulation: `x' = x + T v`, `v' = v + T (u + noise)`.
#[derive(Debug)]
pub struct SimulatedRail {
    setup: Setup,
    config: RailConfig,
    state: Vector2<f64>,
    step: usize,
    world: ChaCha8Rng,
    sensors: ChaCha8Rng,
    waiting: VecDeque<Event>,
}

impl SimulatedRail {
    /// A vehicle as configured.
    ///
    /// # Errors
    /// Values out of range.
    pub fn new(name: &str, config: &RailConfig, seed: u64) -> Result<Self> {
        let belief = config.belief()?;
        let mut state = belief.sample(&mut stream(seed, "start"));
        state.x = config.true_position.unwrap_or(state.x);
        state.y = config.true_speed.unwrap_or(state.y);
        let mut rail = SimulatedRail {
            setup: Setup {
                name: name.into(),
                start: 0.0,
                end: config.steps as f64 * config.time_step,
                start_belief: along_the_rail(&belief),
                rail: Some(belief),
                landmarks: Default::default(),
                map: None,
                lines: None,
                has_laser: false,
                kidnapped_at: None,
            },
            config: config.clone(),
            state,
            step: 0,
            world: stream(seed, "world"),
            sensors: stream(seed, "sensors"),
            waiting: VecDeque::new(),
        };
        rail.report();
        Ok(rail)
    }

    fn drive(&mut self) {
        let dt = self.config.time_step;
        let noise: f64 = StandardNormal.sample(&mut self.world);
        let acceleration = self.config.acceleration + self.config.acceleration_sigma * noise;
        self.state =
            Matrix2::new(1.0, dt, 0.0, 1.0) * self.state + Vector2::new(0.0, dt * acceleration);
        self.step += 1;
        self.report();
    }

    /// The next control, the measurements, and the truth.
    fn report(&mut self) {
        let stamp = self.step as f64 * self.config.time_step;
        let control = Control::Acceleration(self.config.acceleration);
        self.waiting.push_back(Event::now(stamp, Payload::Control(control)));
        for (sensor, config) in self.config.sensors.iter().enumerate() {
            let noise: f64 = StandardNormal.sample(&mut self.sensors);
            let simulated = self.state.x + config.sigma * noise;
            let position = match &config.readings {
                // The initial distribution is the belief before the first step.
                None => (self.step > 0).then_some(simulated),
                Some(given) => given.iter().find(|(step, _)| *step == self.step).map(|(_, z)| *z),
            };
            if let Some(position) = position {
                let measurement = Measurement::RailPosition { sensor, position };
                self.waiting.push_back(Event::now(stamp, Payload::Measurement(measurement)));
            }
        }
        let pose = Pose2::new(self.state.x, 0.0, 0.0);
        let truth = Truth { pose, speed: Some(self.state.y) };
        self.waiting.push_back(Event::now(stamp, Payload::Truth(truth)));
    }
}

impl Source for SimulatedRail {
    fn setup(&self) -> &Setup {
        &self.setup
    }

    fn next_event(&mut self) -> Result<Option<Event>> {
        if self.waiting.is_empty() && self.step < self.config.steps {
            self.drive();
        }
        Ok(self.waiting.pop_front())
    }
}

/// The pose distribution: the rail is the x axis, the other coordinates are certain.
fn along_the_rail(belief: &Gaussian<2>) -> Gaussian<3> {
    let mut pose = Gaussian::certain(Vector3::new(belief.mean.x, 0.0, 0.0));
    pose.covariance[(0, 0)] = belief.covariance[(0, 0)];
    pose
}

/// A vehicle that accelerates along a straight line; its state is (position, speed).
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RailConfig {
    /// Duration of a step, T \[s\].
    pub time_step: f64,
    /// Number of steps.
    pub steps: usize,
    /// Commanded acceleration, u \[m/s^2\].
    #[serde(default)]
    pub acceleration: f64,
    /// Standard deviation of the acceleration about the command \[m/s^2\].
    #[serde(default)]
    pub acceleration_sigma: f64,
    /// Believed position at the start \[m\].
    #[serde(default)]
    pub position: f64,
    /// Its standard deviation \[m\].
    #[serde(default)]
    pub position_sigma: f64,
    /// Believed speed at the start \[m/s\].
    #[serde(default)]
    pub speed: f64,
    /// Its standard deviation \[m/s\].
    #[serde(default)]
    pub speed_sigma: f64,
    /// True position at the start; drawn from the belief where left out \[m\].
    pub true_position: Option<f64>,
    /// True speed at the start; drawn from the belief where left out \[m/s\].
    pub true_speed: Option<f64>,
    /// The position sensors.
    pub sensors: Vec<RailSensorConfig>,
}

/// A sensor of the position.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RailSensorConfig {
    /// Standard deviation of its readings \[m\].
    pub sigma: f64,
    /// Its readings, as pairs of step and position \[m\]; simulated at every step where left out.
    pub readings: Option<Vec<(usize, f64)>>,
}

impl RailConfig {
    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::Config`] and [`loc_core::Error::OutOfRange`] with the key.
    pub(crate) fn check(&self) -> Result<()> {
        positive("rail.time_step", self.time_step)?;
        if self.steps == 0 || self.steps > 100_000_000 {
            return Err(field("rail.steps", "1 to 100000000", &self.steps.to_string()));
        }
        finite("rail.acceleration", self.acceleration)?;
        non_negative("rail.acceleration_sigma", self.acceleration_sigma)?;
        non_negative("rail.position_sigma", self.position_sigma)?;
        non_negative("rail.speed_sigma", self.speed_sigma)?;
        for value in [self.true_position, self.true_speed].into_iter().flatten() {
            finite("rail.true_position, rail.true_speed", value)?;
        }
        for sensor in &self.sensors {
            positive("rail.sensors.sigma", sensor.sigma)?;
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
        let variances = Vector2::new(self.position_sigma.powi(2), self.speed_sigma.powi(2));
        let mean = Vector2::new(self.position, self.speed);
        Ok(Gaussian::new(mean, Matrix2::from_diagonal(&variances))?)
    }

    /// The settings of the filter.
    pub(crate) fn settings(&self) -> RailSettings {
        RailSettings {
            acceleration_sigma: self.acceleration_sigma,
            sensor_sigmas: self.sensors.iter().map(|sensor| sensor.sigma).collect(),
        }
    }
}
