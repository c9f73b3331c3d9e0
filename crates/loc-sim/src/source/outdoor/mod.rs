//! A simulated robot outdoors, with sensors that each have their own pace and fall silent.

mod config;
mod sensors;

pub use config::{
    CompassConfig, CourseConfig, InertialConfig, OutdoorConfig, RadioConfig, SatelliteConfig,
    TimedWheelConfig,
};

use super::reorder::Reorder;
use super::{SensorTruth, Setup, Silence, Source};
use crate::Result;
use loc_core::gaussian::pose_belief;
use loc_core::motion::Integration;
use loc_core::random::stream;
use loc_core::{Pose2, Twist2};
use loc_sensors::event::{Event, Payload, Truth};
use sensors::{Moment, Sensors};
use std::sync::Arc;

/// Time between two true poses \[s\].
const TRUTH_EVERY: f64 = 0.1;

/// A robot in simulation. Its velocity changes as fast as its motors can; it drives arcs.
#[derive(Debug)]
pub struct SimulatedOutdoor {
    setup: Setup,
    /// The velocity to reach, at each step.
    course: Vec<Twist2>,
    /// The most that the velocity changes in a step.
    most: Twist2,
    moment: Moment,
    sensors: Sensors,
    silences: Vec<Silence>,
    truth_every: usize,
    waiting: Reorder,
}

impl SimulatedOutdoor {
    /// A robot as configured.
    ///
    /// # Errors
    /// Values out of range.
    pub fn new(name: &str, config: &OutdoorConfig, seed: u64) -> Result<Self> {
        let mut course = Vec::new();
        for piece in &config.course {
            let steps = config.steps("outdoor.course.duration_s", piece.duration_s)?;
            course.extend(std::iter::repeat_n(piece.twist(), steps));
        }
        let dt = config.time_step_s;
        let pose = config.start.pose();
        let mut start_belief = pose_belief(pose, config.start.sigmas()?);
        start_belief.mean = start_belief.sample(&mut stream(seed, "start"));
        let setup = Setup {
            name: name.into(),
            start: 0.0,
            end: course.len() as f64 * dt,
            start_belief,
            rail: None,
            landmarks: Arc::new(config.map()?),
            map: None,
            lines: None,
            has_laser: false,
            kidnapped_at: None,
        };
        let silence = |(sensor, [from, to]): (_, [f64; 2])| Silence { sensor, from, to };
        let turn = config.turn_acceleration_deg_s2.to_radians();
        let mut robot = SimulatedOutdoor {
            setup,
            course,
            most: Twist2::forward(config.acceleration_m_s2 * dt, turn * dt),
            moment: Moment { step: 0, dt, pose, twist: Twist2::ZERO, change: Twist2::ZERO },
            sensors: Sensors::new(config, seed)?,
            silences: config.silences().into_iter().map(silence).collect(),
            truth_every: (TRUTH_EVERY / dt).round().max(1.0) as usize,
            waiting: Reorder::default(),
        };
        robot.tell_truth();
        Ok(robot)
    }

    fn drive(&mut self, goal: Twist2) {
        let Moment { dt, twist: before, .. } = self.moment;
        let toward = |now: f64, goal: f64, most: f64| now + (goal - now).clamp(-most, most);
        let after = Twist2::forward(
            toward(before.vx, goal.vx, self.most.vx),
            toward(before.omega, goal.omega, self.most.omega),
        );
        let mean =
            Twist2::forward(0.5 * (before.vx + after.vx), 0.5 * (before.omega + after.omega));
        let change =
            Twist2::forward((after.vx - before.vx) / dt, (after.omega - before.omega) / dt);
        let pose = Integration::ExactArc.step(self.moment.pose, mean, dt);
        let step = self.moment.step + 1;
        self.moment = Moment { step, dt, pose, twist: after, change };
        let landmarks = &self.setup.landmarks;
        self.sensors.measure(&self.moment, mean, landmarks, &mut |event| self.waiting.push(event));
        if step.is_multiple_of(self.truth_every) {
            self.tell_truth();
        }
    }

    fn tell_truth(&mut self) {
        let Moment { pose, twist, .. } = self.moment;
        let truth = Truth { pose, speed: Some(twist.vx) };
        self.waiting.push(Event::now(self.moment.stamp(), Payload::Truth(truth)));
    }

    /// The true pose now.
    pub fn pose(&self) -> Pose2 {
        self.moment.pose
    }
}

impl Source for SimulatedOutdoor {
    fn setup(&self) -> &Setup {
        &self.setup
    }

    fn next_event(&mut self) -> Result<Option<Event>> {
        loop {
            let ended = self.moment.step == self.course.len();
            // What the next step brings arrives after now.
            let now = self.moment.stamp() + 0.5 * self.moment.dt;
            if let Some(event) = self.waiting.pop(if ended { f64::INFINITY } else { now }) {
                return Ok(Some(event));
            }
            match self.course.get(self.moment.step).copied() {
                Some(goal) => self.drive(goal),
                None => return Ok(None),
            }
        }
    }

    fn sensor_truth(&self) -> SensorTruth {
        SensorTruth { silences: self.silences.clone(), errors: self.sensors.errors() }
    }
}
