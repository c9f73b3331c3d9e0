//! A simulated vehicle on a rail (G3, G4).

mod config;

pub use config::{RailConfig, RailSensorConfig};

use super::{Setup, Source};
use crate::Result;
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Gaussian, Pose2};
use loc_sensors::event::{Control, Event, Measurement, Payload, Truth};
use nalgebra::{Matrix2, Vector2, Vector3};
use rand_distr::{Distribution, StandardNormal};
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
        state.x = config.true_position_m.unwrap_or(state.x);
        state.y = config.true_speed_m_s.unwrap_or(state.y);
        let mut rail = SimulatedRail {
            setup: Setup {
                name: name.into(),
                start: 0.0,
                end: config.steps as f64 * config.time_step_s,
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
        let dt = self.config.time_step_s;
        let noise: f64 = StandardNormal.sample(&mut self.world);
        let acceleration =
            self.config.acceleration_m_s2 + self.config.acceleration_sigma_m_s2 * noise;
        self.state =
            Matrix2::new(1.0, dt, 0.0, 1.0) * self.state + Vector2::new(0.0, dt * acceleration);
        self.step += 1;
        self.report();
    }

    /// The control that holds from now on, what the sensors read, and the truth.
    fn report(&mut self) {
        let stamp = self.step as f64 * self.config.time_step_s;
        let control = Control::Acceleration(self.config.acceleration_m_s2);
        self.waiting.push_back(Event::now(stamp, Payload::Control(control)));
        for (sensor, config) in self.config.sensors.iter().enumerate() {
            let noise: f64 = StandardNormal.sample(&mut self.sensors);
            let simulated = self.state.x + config.sigma_m * noise;
            let position = match &config.readings {
                // The belief at the start stands for what was known before the first step.
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

/// The rail lies along x: the belief about the position there, certainty about the rest.
fn along_the_rail(belief: &Gaussian<2>) -> Gaussian<3> {
    let mut pose = Gaussian::certain(Vector3::new(belief.mean.x, 0.0, 0.0));
    pose.covariance[(0, 0)] = belief.covariance[(0, 0)];
    pose
}
