//! A simulated robot with a laser that drives a tour through a building.
//!
//! It drives from one target to the next along planned paths that keep off the walls. Its noisy
//! wheel motion is integrated to the continuous pose of its odometry; its laser measures the walls
//! and the people in front of them. It may be kidnapped ([`KidnapConfig`]).
//!
//! Tour, wheels, laser and people have random streams of their own: a run with people, or with
//! another laser, drives the same tour.

mod config;
mod world;

pub use config::{Drawn, KidnapConfig, KidnapTarget, TourConfig};
pub use world::{RobotConfig, TourWorld, WorldConfig};

use super::people::Crowd;
use super::{Setup, Source};
use crate::Result;
use loc_core::error::positive;
use loc_core::gaussian::pose_belief;
use loc_core::motion::Integration;
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Pose2, Twist2};
use loc_maps::{LandmarkMap, LineMap};
use loc_sensors::event::{Control, Event, Measurement, Payload, Truth};
use loc_sensors::landmark_camera::LandmarkCamera;
use loc_sensors::laser::{LaserFaults, LaserScanner, LaserSpec};
use loc_sensors::wheel::WheelOdometry;
use loc_sensors::world::{LandmarkWorld, RangeWorld};
use nalgebra::Point2;
use rand::RngExt;
use serde::Deserialize;
use std::collections::VecDeque;
use std::f64::consts::PI;
use std::sync::Arc;
use world::{Driver, Roads};

/// Smallest distance of a kidnapping, where the building is large enough \[m\].
const CARRIED: f64 = 5.0;
/// Attempts to draw a suitable position.
const TRIES: usize = 100;

/// The simulated robot.
#[derive(Debug)]
pub struct SimulatedTour {
    setup: Setup,
    world: TourWorld,
    roads: Roads,
    driver: Driver,
    stops: VecDeque<Point2<f64>>,
    tour_rng: ChaCha8Rng,
    dt: f64,
    step: usize,
    steps: usize,
    pose: Pose2,
    twist: Twist2,
    wheels: WheelOdometry,
    wheel_rng: ChaCha8Rng,
    /// The pose of the odometry.
    odometry: Pose2,
    scanner: LaserScanner,
    scan_every: usize,
    laser_rng: ChaCha8Rng,
    camera: Option<TourCamera>,
    crowd: Option<Crowd>,
    kidnap: Option<Kidnap>,
    waiting: VecDeque<Event>,
}

impl SimulatedTour {
    /// A robot as configured.
    ///
    /// # Errors
    /// Values out of range, and a building without room for the robot.
    pub fn new(name: &str, config: &TourConfig, seed: u64) -> Result<Self> {
        config.check()?;
        let world = TourWorld::open(config.world.as_ref(), config.map.as_deref())?;
        let roads = Roads::new(&world, config.robot.radius)?;
        let mut tour_rng = stream(seed, "tour");
        let pose = match &config.start {
            Some(start) => on_roads(&roads, "tour.start", start)?,
            None => draw_pose(&roads, &mut tour_rng),
        };
        let stops = config.stops.iter().map(|&stop| roads.nearest("tour.stops", stop.into()));
        let stops = stops.collect::<Result<_>>()?;
        let kidnap = Kidnap::new(config, &roads, seed)?;
        let scanner = config.laser.scanner()?;
        let crowd = config
            .people
            .as_ref()
            .map(|people| Crowd::new(people, &world, &scanner, pose, stream(seed, "people")));
        let mut tour = SimulatedTour {
            setup: setup(name, config, &world, pose, seed)?,
            world,
            roads,
            driver: Driver::new(config.robot),
            stops,
            tour_rng,
            dt: config.time_step,
            step: 0,
            steps: config.steps("tour.duration", config.duration)?,
            pose,
            twist: Twist2::ZERO,
            wheels: config.odometry()?,
            wheel_rng: stream(seed, "odometry"),
            odometry: Pose2::IDENTITY,
            scanner,
            scan_every: config.steps("tour.laser.every", config.laser.every)?,
            laser_rng: stream(seed, "laser"),
            camera: TourCamera::new(config, seed)?,
            crowd,
            kidnap,
            waiting: VecDeque::new(),
        };
        tour.tell();
        Ok(tour)
    }

    /// The building.
    pub fn world(&self) -> &TourWorld {
        &self.world
    }

    fn stamp(&self) -> f64 {
        self.step as f64 * self.dt
    }

    /// Drives one step; wheels and laser report at its end.
    fn drive(&mut self) {
        if self.driver.has_arrived(self.pose) {
            let way = self.next_stop().and_then(|to| self.roads.way(self.pose.position(), to));
            self.driver.follow(way.unwrap_or_default());
        }
        self.twist = self.driver.steer(&self.world, self.pose, self.dt);
        self.pose = Integration::ExactArc.step(self.pose, self.twist, self.dt);
        let reading = self.wheels.measure(self.twist, self.dt, &mut self.wheel_rng);
        self.odometry = Integration::ExactArc.step(self.odometry, reading, self.dt);
        self.step += 1;
        if let Some(kidnap) = self.kidnap.as_mut().filter(|kidnap| kidnap.step == self.step) {
            self.pose = kidnap.target(&self.roads, self.pose);
            self.driver.stop();
        }
        if let Some(crowd) = &mut self.crowd {
            crowd.step(&self.world, self.pose, self.dt);
        }
        self.tell();
    }

    /// The next target: the configured ones in turn, or a random one.
    fn next_stop(&mut self) -> Option<Point2<f64>> {
        if self.stops.is_empty() {
            return Some(self.roads.draw(&mut self.tour_rng));
        }
        self.stops.rotate_left(1);
        self.stops.back().copied()
    }

    /// The events of this time: odometry, then scan and landmarks, then the truth.
    fn tell(&mut self) {
        let stamp = self.stamp();
        let mut tell = |payload| self.waiting.push_back(Event::now(stamp, payload));
        tell(Payload::Control(Control::Odometry(self.odometry)));
        if self.step.is_multiple_of(self.scan_every) {
            let (pose, rng) = (self.pose, &mut self.laser_rng);
            let scan = match &self.crowd {
                Some(crowd) => self.scanner.scan(&crowd.with_people(&self.world.walls), pose, rng),
                None => self.scanner.scan(&self.world.walls, pose, rng),
            };
            let (scan, mounting) = (Arc::new(scan), self.scanner.mounting);
            tell(Payload::Measurement(Measurement::Scan { scan, mounting }));
        }
        if let Some(camera) = &mut self.camera
            && let Some(seen) = camera.look(self.step, &self.world, self.pose)
        {
            tell(Payload::Measurement(seen));
        }
        tell(Payload::Truth(Truth { pose: self.pose, speed: Some(self.twist.vx) }));
    }
}

impl Source for SimulatedTour {
    fn setup(&self) -> &Setup {
        &self.setup
    }

    fn next_event(&mut self) -> Result<Option<Event>> {
        if self.waiting.is_empty() && self.step < self.steps {
            self.drive();
        }
        Ok(self.waiting.pop_front())
    }
}

/// What is known before the tour.
fn setup(
    name: &str,
    config: &TourConfig,
    world: &TourWorld,
    pose: Pose2,
    seed: u64,
) -> Result<Setup> {
    let mut start_belief = pose_belief(pose, config.start_sigma.sigmas()?);
    start_belief.mean = start_belief.sample(&mut stream(seed, "start"));
    Ok(Setup {
        name: name.into(),
        start: 0.0,
        end: config.duration,
        start_belief,
        rail: None,
        // Without a camera, landmarks are not used.
        landmarks: if config.camera.is_some() { world.landmarks.clone() } else { Arc::default() },
        map: Some(world.grid.clone()),
        // Its walls are cells; the laser measures their outline.
        lines: Some(Arc::new(LineMap::outline(&world.grid)?)),
        has_laser: true,
        kidnapped_at: config.kidnap.map(|kidnap| kidnap.at),
    })
}

/// A configured pose, moved to the nearest position with room for the robot.
fn on_roads(roads: &Roads, key: &str, pose: &Pose2) -> Result<Pose2> {
    let place = roads.nearest(key, pose.position())?;
    Ok(Pose2 { x: place.x, y: place.y, ..*pose })
}

fn draw_pose(roads: &Roads, rng: &mut ChaCha8Rng) -> Pose2 {
    let place = roads.draw(rng);
    Pose2::new(place.x, place.y, PI * (2.0 * rng.random::<f64>() - 1.0))
}

/// A future kidnapping.
#[derive(Debug)]
struct Kidnap {
    /// At the end of this step.
    step: usize,
    /// To this pose, or anywhere.
    to: Option<Pose2>,
    rng: ChaCha8Rng,
}

impl Kidnap {
    fn new(config: &TourConfig, roads: &Roads, seed: u64) -> Result<Option<Self>> {
        let Some(KidnapConfig { at, to }) = config.kidnap else { return Ok(None) };
        let to = match to {
            KidnapTarget::Pose(pose) => Some(on_roads(roads, "tour.kidnap.to", &pose)?),
            KidnapTarget::Drawn(Drawn::Random) => None,
        };
        // Checked to lie within the tour.
        let step = (at / config.time_step).round() as usize;
        Ok(Some(Kidnap { step, to, rng: stream(seed, "kidnap") }))
    }

    /// The pose after the kidnapping of a robot at `pose`.
    fn target(&mut self, roads: &Roads, pose: Pose2) -> Pose2 {
        self.to.unwrap_or_else(|| {
            let draws = (0..TRIES).map(|_| draw_pose(roads, &mut self.rng));
            let draws: Vec<Pose2> = draws.collect();
            let far = draws.iter().find(|to| to.distance(pose) >= CARRIED);
            far.or(draws.last()).copied().unwrap_or(pose)
        })
    }
}

/// A laser scanner on a robot.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LaserConfig {
    /// Its data sheet.
    pub preset: LaserPreset,
    /// Time between two scans that are looked at; a multiple of the time step \[s\].
    #[serde(default = "every")]
    pub every: f64,
    /// Its pose on the robot, `base_from_laser`.
    #[serde(default, with = "loc_core::settings::pose")]
    pub mounting: Pose2,
    /// Standard deviation of a range, where it is not the data sheet's \[m\].
    pub sigma: Option<f64>,
    /// Longest range, where it is not the data sheet's \[m\].
    pub max_range: Option<f64>,
    /// What goes wrong with single beams, as probabilities: `dropout`, `erroneous`, `short`.
    #[serde(default)]
    pub faults: LaserFaults,
}

/// Scanners with a data sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub enum LaserPreset {
    /// [`LaserSpec::hokuyo_ust_10lx`]: 270 deg in 0.25 deg, up to 10 m.
    #[serde(rename = "hokuyo-ust-10lx")]
    HokuyoUst10Lx,
    /// [`LaserSpec::sick_lms100`]: 270 deg in 0.25 deg, up to 18 m.
    #[serde(rename = "sick-lms100")]
    SickLms100,
    /// [`LaserSpec::sick_lms100_50_hz`]: 270 deg in 0.5 deg, up to 18 m.
    #[serde(rename = "sick-lms100-50hz")]
    SickLms100At50Hz,
}

fn every() -> f64 {
    0.2
}

impl LaserConfig {
    /// The library's form.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub fn scanner(&self) -> Result<LaserScanner> {
        positive("laser.every", self.every)?;
        let mut spec = match self.preset {
            LaserPreset::HokuyoUst10Lx => LaserSpec::hokuyo_ust_10lx(),
            LaserPreset::SickLms100 => LaserSpec::sick_lms100(),
            LaserPreset::SickLms100At50Hz => LaserSpec::sick_lms100_50_hz(),
        };
        spec.noise.sigma = self.sigma.unwrap_or(spec.noise.sigma);
        spec.range_max = self.max_range.unwrap_or(spec.range_max);
        let mounting = self.mounting;
        let scanner = LaserScanner { mounting, spec, faults: self.faults };
        scanner.check()?;
        Ok(scanner)
    }
}

/// A landmark hangs on a wall, hence within a cell or two of one \[m\].
const ON_THE_WALL: f64 = 0.15;

/// A camera that looks now and then.
#[derive(Debug)]
struct TourCamera {
    camera: LandmarkCamera,
    every: usize,
    rng: ChaCha8Rng,
}

impl TourCamera {
    /// The camera, where the configuration has one.
    fn new(config: &TourConfig, seed: u64) -> Result<Option<Self>> {
        let Some(camera) = &config.camera else { return Ok(None) };
        Ok(Some(TourCamera {
            camera: camera.camera()?,
            every: config.steps("tour.camera.every", camera.every)?,
            rng: stream(seed, "camera"),
        }))
    }

    /// What it sees at a step, where it looks and something is in view.
    fn look(&mut self, step: usize, world: &TourWorld, pose: Pose2) -> Option<Measurement> {
        if !step.is_multiple_of(self.every) {
            return None;
        }
        let observations = self.camera.observe(&InSight(world), pose, &mut self.rng);
        (!observations.is_empty()).then_some(Measurement::Landmarks(observations))
    }
}

/// The landmarks of a building that no wall hides.
struct InSight<'a>(&'a TourWorld);

impl LandmarkWorld for InSight<'_> {
    fn visit_landmarks(
        &self,
        center: &Point2<f64>,
        radius: f64,
        visit: &mut dyn FnMut(u32, Point2<f64>),
    ) {
        let landmarks: &LandmarkMap = &self.0.landmarks;
        landmarks.visit_landmarks(center, radius, &mut |id, position| {
            let way = position - center;
            let free = way.norm() - ON_THE_WALL;
            if free <= 0.0 || self.0.walls.cast(center, way.y.atan2(way.x), free).is_none() {
                visit(id, position);
            }
        });
    }
}
