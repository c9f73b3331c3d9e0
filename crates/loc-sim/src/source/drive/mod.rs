//! A simulated robot that drives a course among landmarks.

mod body;

pub use body::{AckermannConfig, LegConfig, MecanumConfig, WheelConfig};

use super::tour::WorldConfig;
use super::{ArrivalQueue, Setup, Source, StartSigma};
use crate::Result;
use crate::config::field;
use body::{Body, BodyOdometry};
use loc_core::error::{finite, non_negative, positive};
use loc_core::gaussian::pose_belief;
use loc_core::motion::Integration;
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Pose2, Twist2};
use loc_filters::RobotSettings;
use loc_maps::{Landmark, LandmarkMap, OccupancyGrid, worlds};
use loc_sensors::event::{Control, Event, Measurement, Payload, Truth};
use loc_sensors::landmark_camera::{LandmarkCamera, LandmarkNoise, ObservedKind};
use serde::Deserialize;
use std::sync::Arc;

/// A simulated robot. It drives exact arcs; odometry and camera measure with errors, each from its
/// own random stream.
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
    queue: ArrivalQueue,
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
            let steps = config.steps("drive.course.duration", segment.duration)?;
            course.extend(std::iter::repeat_n(config.twist(segment)?, steps));
        }
        let pose = config.start;
        let mut start_belief = pose_belief(pose, config.start_sigma.sigmas()?);
        start_belief.mean = start_belief.sample(&mut stream(seed, "start"));
        let (landmarks, floor) = config.map()?;
        let setup = Setup {
            name: name.into(),
            start: 0.0,
            end: course.len() as f64 * config.time_step,
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
                every: config.steps("drive.camera.every", camera.every)?,
                latency: camera.latency,
                rng: stream(seed, "camera"),
            }),
        };
        let mut drive = SimulatedDrive {
            setup,
            course,
            step: 0,
            dt: config.time_step,
            pose,
            odometry: config.body()?.odometry()?,
            odometry_rng: stream(seed, "odometry"),
            camera,
            queue: ArrivalQueue::default(),
        };
        drive.tell_truth();
        Ok(drive)
    }

    fn stamp(&self) -> f64 {
        self.step as f64 * self.dt
    }

    /// Drives one step; the odometry reports it at its end.
    fn drive(&mut self, twist: Twist2) {
        let stamp = self.stamp();
        self.pose = Integration::ExactArc.step(self.pose, twist, self.dt);
        self.step += 1;
        let reading = self.odometry.measure(twist, self.dt, &mut self.odometry_rng);
        let payload = Payload::Control(Control::Velocity(reading));
        self.queue.push(Event { stamp, arrival: self.stamp(), payload });
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
            self.queue.push(Event { stamp, arrival: stamp + camera.latency, payload });
        }
    }

    fn tell_truth(&mut self) {
        let speed = self.course.get(self.step.saturating_sub(1)).map(|twist| twist.vx);
        let truth = Truth { pose: self.pose, speed };
        self.queue.push(Event::now(self.stamp(), Payload::Truth(truth)));
    }
}

impl Source for SimulatedDrive {
    fn setup(&self) -> &Setup {
        &self.setup
    }

    fn next_event(&mut self) -> Result<Option<Event>> {
        loop {
            let ended = self.step == self.course.len();
            // Events of the next step arrive later.
            let known_until = if ended { f64::INFINITY } else { self.stamp() + 0.5 * self.dt };
            if let Some(event) = self.queue.pop(known_until) {
                return Ok(Some(event));
            }
            match self.course.get(self.step).copied() {
                Some(twist) => self.drive(twist),
                None => return Ok(None),
            }
        }
    }
}

/// A robot that drives a course among landmarks.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriveConfig {
    /// Time between two readings of the odometry \[s\].
    pub time_step: f64,
    /// The start.
    #[serde(default, with = "loc_core::settings::pose")]
    pub start: Pose2,
    /// How well the start is known.
    #[serde(default)]
    pub start_sigma: StartSigma,
    /// The course, piece by piece.
    pub course: Vec<Segment>,
    /// The wheels of a differential drive and their odometry. One of this and the following.
    pub wheels: Option<WheelConfig>,
    /// Legs and their odometry.
    pub legs: Option<LegConfig>,
    /// The steering of a car.
    pub ackermann: Option<AckermannConfig>,
    /// Wheels that go in every direction.
    pub mecanum: Option<MecanumConfig>,
    /// The camera, if there is one.
    pub camera: Option<CameraConfig>,
    /// A generated world with its landmarks. Either this or `landmarks`.
    pub world: Option<WorldConfig>,
    /// The landmarks.
    #[serde(default)]
    pub landmarks: Vec<LandmarkConfig>,
}

/// A piece of the course at constant velocity: either `v`, `sideways` and `omega`, or
/// what the wheels do.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Segment {
    /// How long it lasts; a multiple of the time step \[s\].
    pub duration: f64,
    /// Forward speed \[m/s\].
    pub v: Option<f64>,
    /// Speed to the left, of a robot on legs or on Mecanum wheels \[m/s\].
    pub sideways: Option<f64>,
    /// Turn rate, counter-clockwise \[rad/s\].
    #[serde(default, with = "loc_core::settings::angle_per_s")]
    pub omega: Option<f64>,
    /// Speed of the left wheel \[m/s\].
    pub left: Option<f64>,
    /// Speed of the right wheel \[m/s\].
    pub right: Option<f64>,
    /// Steering angle of a car, counter-clockwise \[rad\].
    #[serde(default, with = "loc_core::settings::angle")]
    pub steering: Option<f64>,
    /// Rim speeds of Mecanum wheels: front left and right, rear left and right \[m/s\].
    pub wheels: Option<[f64; 4]>,
}

/// A camera that sees landmarks.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraConfig {
    /// Time between two images; a multiple of the time step \[s\].
    pub every: f64,
    /// Time from an image to its result \[s\].
    #[serde(default)]
    pub latency: f64,
    /// Its pose on the robot, `base_from_camera`.
    #[serde(default, with = "loc_core::settings::pose")]
    pub mounting: Pose2,
    /// Opening angle \[rad\].
    #[serde(with = "loc_core::settings::angle")]
    pub fov: f64,
    /// Nearest distance \[m\].
    #[serde(default)]
    pub min_range: f64,
    /// Farthest distance \[m\].
    pub max_range: f64,
    /// `range-bearing`, `range` or `bearing`.
    #[serde(default)]
    pub kind: ObservedKind,
    /// Probability that a landmark in view is detected.
    #[serde(default = "one")]
    pub detection_probability: f64,
    /// Probability that a detected landmark gets the number of another one.
    #[serde(default)]
    pub wrong_identity_probability: f64,
    /// Random errors.
    pub noise: LandmarkNoise,
}

/// A landmark of the world.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LandmarkConfig {
    /// Its number.
    pub id: u32,
    /// Its position \[m\].
    pub x: f64,
    /// Its position \[m\].
    pub y: f64,
}

fn one() -> f64 {
    1.0
}

impl DriveConfig {
    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::Config`] and [`loc_core::Error::OutOfRange`] with the key.
    pub(crate) fn check(&self) -> Result<()> {
        positive("drive.time_step", self.time_step)?;
        if self.course.is_empty() {
            return Err(field("drive.course", "at least one segment", ""));
        }
        for segment in &self.course {
            self.steps("drive.course.duration", segment.duration)?;
            self.twist(segment)?;
        }
        if let Some(camera) = &self.camera {
            self.steps("drive.camera.every", camera.every)?;
            non_negative("drive.camera.latency", camera.latency)?;
            camera.camera()?;
        }
        self.start.check()?;
        self.start_sigma.sigmas()?;
        self.body()?.odometry()?;
        self.map()?;
        Ok(())
    }

    /// How many time steps a duration lasts.
    ///
    /// # Errors
    /// [`crate::Error::Config`] for one that is no positive multiple of the time step.
    pub(crate) fn steps(&self, key: &'static str, duration: f64) -> Result<usize> {
        positive(key, duration)?;
        let steps = duration / self.time_step;
        let whole = steps.round();
        if whole < 1.0 || (steps - whole).abs() > 1e-6 * whole || whole > 1e8 {
            let expected = format!("a multiple of the time step {} s", self.time_step);
            return Err(field(key, &expected, &duration.to_string()));
        }
        // Checked to be a whole number between 1 and 1e8.
        Ok(whole as usize)
    }

    /// The velocity of a segment.
    ///
    /// # Errors
    /// [`crate::Error::Config`] unless it is given in exactly one of the two ways.
    pub(crate) fn twist(&self, segment: &Segment) -> Result<Twist2> {
        let body = self.body()?;
        let Segment { v, sideways, omega, .. } = *segment;
        let by_body = v.is_some() || sideways.is_some();
        let turns = omega.is_some();
        let from_wheels = if turns { None } else { body.by_wheels(segment)? };
        let names_wheels = segment.left.is_some()
            || segment.right.is_some()
            || segment.steering.is_some()
            || segment.wheels.is_some();
        let sidesteps = sideways.is_some() && !body.can_sidestep();
        let twist = match from_wheels {
            Some(twist) if sideways.is_none() => twist,
            None if by_body && !names_wheels && !sidesteps => {
                let omega = omega.unwrap_or(0.0);
                Twist2::new(v.unwrap_or(0.0), sideways.unwrap_or(0.0), omega)
            }
            _ => return Err(field("drive.course", body.segment_keys(), &format!("{segment:?}"))),
        };
        finite("drive.course: speed [m/s]", twist.vx)?;
        finite("drive.course: speed to the left [m/s]", twist.vy)?;
        finite("drive.course: turn rate [rad/s]", twist.omega)?;
        body.check(twist)?;
        Ok(twist)
    }

    /// The drive of the robot.
    ///
    /// # Errors
    /// [`crate::Error::Config`] unless it is one thing.
    fn body(&self) -> Result<Body<'_>> {
        Body::of(self)
    }

    /// The landmarks as a map, and the grid map of their world, where there is one.
    ///
    /// # Errors
    /// [`loc_maps::Error`] for a number that occurs twice, [`crate::Error::Config`] for landmarks
    /// beside those of a world.
    pub(crate) fn map(&self) -> Result<(LandmarkMap, Option<OccupancyGrid>)> {
        let planar = |l: &LandmarkConfig| Landmark::planar(l.id, l.x, l.y);
        let Some(world) = &self.world else {
            return Ok((LandmarkMap::new(self.landmarks.iter().map(planar))?, None));
        };
        if !self.landmarks.is_empty() {
            return Err(field("drive.landmarks", "none beside those of the world", "some"));
        }
        let world = worlds::by_name(&world.name, &world.settings()?)?;
        Ok((world.landmarks, Some(world.grid)))
    }

    /// The default settings of the methods: the true noise.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub(crate) fn robot(&self) -> Result<RobotSettings> {
        let mut settings = RobotSettings::default().odometry(self.body()?.noise()?);
        if let Some(camera) = &self.camera {
            let LandmarkCamera { mounting, noise, .. } = camera.camera()?;
            settings = settings.mounting(mounting).camera(noise);
        }
        Ok(settings)
    }
}

impl CameraConfig {
    /// The library's form.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub(crate) fn camera(&self) -> Result<LandmarkCamera> {
        let camera = LandmarkCamera {
            mounting: self.mounting,
            fov: self.fov,
            min_range: self.min_range,
            max_range: self.max_range,
            kind: self.kind,
            detection_probability: self.detection_probability,
            wrong_identity_probability: self.wrong_identity_probability,
            noise: self.noise,
        };
        camera.check()?;
        Ok(camera)
    }
}
