//! A simulated robot that drives a course among landmarks.

mod body;

pub use body::{AckermannConfig, LegConfig, MecanumConfig, WheelConfig};

use super::tour::WorldConfig;
use super::{ArrivalQueue, ObservationNoiseConfig, Setup, Source};
use crate::Result;
use crate::config::field;
use body::{Body, BodyOdometry};
use loc_core::error::{finite, non_negative, positive};
use loc_core::gaussian::pose_belief;
use loc_core::motion::Integration;
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Pose2, Twist2};
use loc_filters::landmark::RobotSettings;
use loc_maps::{Landmark, LandmarkMap, OccupancyGrid, worlds};
use loc_sensors::event::{Control, Event, Measurement, Payload, Truth};
use loc_sensors::landmark_camera::{LandmarkCamera, ObservedKind};
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
    /// Time between two readings of the odometry.
    pub time_step_s: f64,
    /// The start.
    #[serde(default)]
    pub start: StartConfig,
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

/// Where a robot starts, and how well that is known.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StartConfig {
    /// Position.
    pub x_m: f64,
    /// Position.
    pub y_m: f64,
    /// Heading, counter-clockwise.
    pub heading_deg: f64,
    /// Standard deviation of x and of y; the filters start at a pose drawn from it.
    pub position_sigma_m: f64,
    /// Standard deviation of the heading.
    pub heading_sigma_deg: f64,
}

/// A piece of the course at constant velocity: either `v_m_s`, `sideways_m_s` and `omega_deg_s`, or
/// what the wheels do.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Segment {
    /// How long it lasts; a multiple of the time step.
    pub duration_s: f64,
    /// Forward speed.
    pub v_m_s: Option<f64>,
    /// Speed to the left, of a robot on legs or on Mecanum wheels.
    pub sideways_m_s: Option<f64>,
    /// Turn rate, counter-clockwise.
    pub omega_deg_s: Option<f64>,
    /// Speed of the left wheel.
    pub left_m_s: Option<f64>,
    /// Speed of the right wheel.
    pub right_m_s: Option<f64>,
    /// Steering angle of a car, counter-clockwise.
    pub steering_deg: Option<f64>,
    /// Rim speeds of Mecanum wheels: front left and right, rear left and right.
    pub wheels_m_s: Option<[f64; 4]>,
}

/// A camera that sees landmarks.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraConfig {
    /// Time between two images; a multiple of the time step.
    pub every_s: f64,
    /// Time from an image to its result.
    #[serde(default)]
    pub latency_s: f64,
    /// Where it sits on the robot: forward.
    #[serde(default)]
    pub forward_m: f64,
    /// Where it sits on the robot: to the left.
    #[serde(default)]
    pub left_m: f64,
    /// How it is turned, counter-clockwise.
    #[serde(default)]
    pub yaw_deg: f64,
    /// Opening angle.
    pub fov_deg: f64,
    /// Nearest distance.
    #[serde(default)]
    pub min_range_m: f64,
    /// Farthest distance.
    pub max_range_m: f64,
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
    pub noise: ObservationNoiseConfig,
}

/// A landmark of the world.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LandmarkConfig {
    /// Its number.
    pub id: u32,
    /// Its position.
    pub x_m: f64,
    /// Its position.
    pub y_m: f64,
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
        positive("drive.time_step_s", self.time_step_s)?;
        if self.course.is_empty() {
            return Err(field("drive.course", "at least one segment", ""));
        }
        for segment in &self.course {
            self.steps("drive.course.duration_s", segment.duration_s)?;
            self.twist(segment)?;
        }
        if let Some(camera) = &self.camera {
            self.steps("drive.camera.every_s", camera.every_s)?;
            non_negative("drive.camera.latency_s", camera.latency_s)?;
            camera.camera()?;
        }
        for value in [self.start.x_m, self.start.y_m, self.start.heading_deg] {
            finite("drive.start", value)?;
        }
        self.start.sigmas()?;
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
        let steps = duration / self.time_step_s;
        let whole = steps.round();
        if whole < 1.0 || (steps - whole).abs() > 1e-6 * whole || whole > 1e8 {
            let expected = format!("a multiple of the time step {} s", self.time_step_s);
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
        let Segment { v_m_s, sideways_m_s, omega_deg_s, .. } = *segment;
        let by_body = v_m_s.is_some() || sideways_m_s.is_some();
        let turns = omega_deg_s.is_some();
        let from_wheels = if turns { None } else { body.by_wheels(segment)? };
        let names_wheels = segment.left_m_s.is_some()
            || segment.right_m_s.is_some()
            || segment.steering_deg.is_some()
            || segment.wheels_m_s.is_some();
        let sidesteps = sideways_m_s.is_some() && !body.can_sidestep();
        let twist = match from_wheels {
            Some(twist) if sideways_m_s.is_none() => twist,
            None if by_body && !names_wheels && !sidesteps => {
                let omega = omega_deg_s.unwrap_or(0.0).to_radians();
                Twist2::new(v_m_s.unwrap_or(0.0), sideways_m_s.unwrap_or(0.0), omega)
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
        let planar = |l: &LandmarkConfig| Landmark::planar(l.id, l.x_m, l.y_m);
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
    pub(crate) fn settings(&self) -> Result<RobotSettings> {
        let mut settings =
            RobotSettings::default().odometry(self.body()?.noise()?);
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
            mounting: Pose2::new(self.forward_m, self.left_m, self.yaw_deg.to_radians()),
            fov: self.fov_deg.to_radians(),
            min_range: self.min_range_m,
            max_range: self.max_range_m,
            kind: self.kind,
            detection_probability: self.detection_probability,
            wrong_identity_probability: self.wrong_identity_probability,
            noise: self.noise.noise()?,
        };
        camera.check()?;
        Ok(camera)
    }
}

impl StartConfig {
    /// The true start pose.
    pub fn pose(&self) -> Pose2 {
        Pose2::new(self.x_m, self.y_m, self.heading_deg.to_radians())
    }

    /// Standard deviations of (x, y, heading) \[m, m, rad\].
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for negative ones.
    pub fn sigmas(&self) -> Result<[f64; 3]> {
        let position = non_negative("position_sigma_m", self.position_sigma_m)?;
        let heading = non_negative("heading_sigma_deg", self.heading_sigma_deg)?;
        Ok([position, position, heading.to_radians()])
    }
}
