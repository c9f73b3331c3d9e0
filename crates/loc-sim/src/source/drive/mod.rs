//! A simulated robot that drives a course among landmarks.

mod body;
mod config;

pub use body::{AckermannConfig, LegConfig, MecanumConfig, WheelConfig};
pub use config::{CameraConfig, DriveConfig, LandmarkConfig, Segment, StartConfig};

use super::reorder::Reorder;
use super::{Setup, Source};
use crate::Result;
use body::BodyOdometry;
use loc_core::gaussian::pose_belief;
use loc_core::motion::Integration;
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Pose2, Twist2};
use loc_maps::LandmarkMap;
use loc_sensors::event::{Control, Event, Measurement, Payload, Truth};
use loc_sensors::landmark_camera::LandmarkCamera;
use std::sync::Arc;

/// A robot in simulation. It drives exact arcs; its odometry and its camera see them with errors,
/// each from a random stream of its own.
#[derive(Debug)]
pub struct SimulatedDrive {
    setup: Setup,
    /// Velocity of each step.
    course: Vec<Twist2>,
    step: usize,
    dt: f64,
    pose: Pose2,
    odometry: BodyOdometry,
    odometry_rng: ChaCha8Rng,
    camera: Option<Camera>,
    waiting: Reorder,
}

#[derive(Debug)]
struct Camera {
    camera: LandmarkCamera,
    every: usize,
    latency: f64,
    rng: ChaCha8Rng,
}

impl SimulatedDrive {
    /// A robot as configured.
    ///
    /// # Errors
    /// Values out of range.
    pub fn new(name: &str, config: &DriveConfig, seed: u64) -> Result<Self> {
        let mut course = Vec::new();
        for segment in &config.course {
            let steps = config.steps("drive.course.duration_s", segment.duration_s)?;
            course.extend(std::iter::repeat_n(config.twist(segment)?, steps));
        }
        let pose = config.start.pose();
        let mut start_belief = pose_belief(pose, config.start.sigmas()?);
        start_belief.mean = start_belief.sample(&mut stream(seed, "start"));
        let (landmarks, floor) = config.map()?;
        let setup = Setup {
            name: name.into(),
            start: 0.0,
            end: course.len() as f64 * config.time_step_s,
            start_belief,
            rail: None,
            landmarks: Arc::new(landmarks),
            map: floor.map(Arc::new),
            lines: None,
            has_laser: false,
            kidnapped_at: None,
        };
        let camera = match &config.camera {
            None => None,
            Some(camera) => Some(Camera {
                camera: camera.camera()?,
                every: config.steps("drive.camera.every_s", camera.every_s)?,
                latency: camera.latency_s,
                rng: stream(seed, "camera"),
            }),
        };
        let mut drive = SimulatedDrive {
            setup,
            course,
            step: 0,
            dt: config.time_step_s,
            pose,
            odometry: config.body()?.odometry()?,
            odometry_rng: stream(seed, "odometry"),
            camera,
            waiting: Reorder::default(),
        };
        drive.tell_truth();
        Ok(drive)
    }

    fn stamp(&self) -> f64 {
        self.step as f64 * self.dt
    }

    /// Drives one step; the odometry reports it when it is over.
    fn drive(&mut self, twist: Twist2) {
        let stamp = self.stamp();
        self.pose = Integration::ExactArc.step(self.pose, twist, self.dt);
        self.step += 1;
        let reading = self.odometry.measure(twist, self.dt, &mut self.odometry_rng);
        let payload = Payload::Control(Control::Velocity(reading));
        self.waiting.push(Event { stamp, arrival: self.stamp(), payload });
        self.look();
        self.tell_truth();
    }

    fn look(&mut self) {
        let (stamp, landmarks): (f64, &LandmarkMap) = (self.stamp(), &self.setup.landmarks);
        let Some(camera) = &mut self.camera else { return };
        if !self.step.is_multiple_of(camera.every) {
            return;
        }
        let observations = camera.camera.observe(landmarks, self.pose, &mut camera.rng);
        if !observations.is_empty() {
            let payload = Payload::Measurement(Measurement::Landmarks(observations));
            self.waiting.push(Event { stamp, arrival: stamp + camera.latency, payload });
        }
    }

    fn tell_truth(&mut self) {
        let speed = self.course.get(self.step.saturating_sub(1)).map(|twist| twist.vx);
        let truth = Truth { pose: self.pose, speed };
        self.waiting.push(Event::now(self.stamp(), Payload::Truth(truth)));
    }
}

impl Source for SimulatedDrive {
    fn setup(&self) -> &Setup {
        &self.setup
    }

    fn next_event(&mut self) -> Result<Option<Event>> {
        loop {
            let ended = self.step == self.course.len();
            // What the next step brings arrives after now.
            let known_until = if ended { f64::INFINITY } else { self.stamp() + 0.5 * self.dt };
            if let Some(event) = self.waiting.pop(known_until) {
                return Ok(Some(event));
            }
            match self.course.get(self.step).copied() {
                Some(twist) => self.drive(twist),
                None => return Ok(None),
            }
        }
    }
}
