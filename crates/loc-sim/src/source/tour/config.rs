//! The configuration of a robot with a laser in a building.

use super::{LaserConfig, RobotConfig, WorldConfig};
use crate::Result;
use crate::config::field;
use crate::source::OdometryNoiseConfig;
use crate::source::drive::CameraConfig;
use crate::source::people::PeopleConfig;
use loc_core::Pose2;
use loc_core::error::{finite, non_negative, positive};
use loc_core::motion::VelocityNoise;
use loc_filters::landmark::RobotSettings;
use loc_sensors::landmark_camera::LandmarkCamera;
use loc_sensors::wheel::{WheelFaults, WheelOdometry};
use serde::Deserialize;
use std::path::PathBuf;

/// A robot that drives a tour through a building, with wheels and a laser.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TourConfig {
    /// A generated world. Either this or `map`.
    pub world: Option<WorldConfig>,
    /// A map of map_server, from the folder that the command runs in.
    pub map: Option<PathBuf>,
    /// How long the tour lasts; a multiple of the time step.
    pub duration_s: f64,
    /// Time between two readings of the odometry.
    pub time_step_s: f64,
    /// Where it starts; anywhere where left out.
    pub start: Option<PoseConfig>,
    /// How well the start is known.
    #[serde(default)]
    pub start_sigma: StartSigmaConfig,
    /// Places to visit, x and y \[m\], again and again; drawn anew all the time where left out.
    #[serde(default)]
    pub stops: Vec<[f64; 2]>,
    /// What the robot can do.
    #[serde(default)]
    pub robot: RobotConfig,
    /// The wheels and their odometry.
    pub wheels: TourWheelConfig,
    /// The laser.
    pub laser: LaserConfig,
    /// A camera that sees the landmarks of the world.
    pub camera: Option<CameraConfig>,
    /// People who walk about and stand in the way of beams.
    pub people: Option<PeopleConfig>,
    /// The robot is carried to another place without being told (A3).
    pub kidnap: Option<KidnapConfig>,
}

/// A pose, in the units of configuration files.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PoseConfig {
    /// Position.
    pub x_m: f64,
    /// Position.
    pub y_m: f64,
    /// Heading, counter-clockwise.
    pub heading_deg: f64,
}

/// How well a start is known; the filters start at a pose drawn from it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StartSigmaConfig {
    /// Standard deviation of x and of y.
    pub position_m: f64,
    /// Standard deviation of the heading.
    pub heading_deg: f64,
}

/// A differential drive and what its odometry gets wrong.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TourWheelConfig {
    /// Distance between the wheels.
    pub track_m: f64,
    /// Random errors.
    pub noise: Option<OdometryNoiseConfig>,
    /// Systematic errors.
    #[serde(default)]
    pub faults: WheelFaults,
}

/// When and where to the robot is carried.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KidnapConfig {
    /// When; a multiple of the time step.
    pub at_s: f64,
    /// Where to: a pose, or `"random"` for anywhere at least 5 m away.
    pub to: KidnapTarget,
}

/// Where a robot is carried to.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum KidnapTarget {
    /// To this pose.
    Pose(PoseConfig),
    /// To any place.
    Drawn(Drawn),
}

/// A place that is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Drawn {
    /// From all places, evenly.
    Random,
}

impl TourConfig {
    /// Checks every value, as far as that is possible without the building.
    ///
    /// # Errors
    /// [`crate::Error::Config`] and [`loc_core::Error::OutOfRange`] with the key.
    pub(crate) fn check(&self) -> Result<()> {
        positive("tour.time_step_s", self.time_step_s)?;
        self.steps("tour.duration_s", self.duration_s)?;
        self.steps("tour.laser.every_s", self.laser.every_s)?;
        match (&self.world, &self.map) {
            (Some(world), None) => world.settings().map(|_| ())?,
            (None, Some(_)) => {}
            (world, _) => {
                let found = if world.is_some() { "both" } else { "none" };
                return Err(field("tour.world, tour.map", "one of the two", found));
            }
        }
        for value in self.stops.iter().flatten() {
            finite("tour.stops", *value)?;
        }
        self.start.map_or(Ok(()), |start| start.check("tour.start"))?;
        self.start_sigmas()?;
        self.robot.check()?;
        self.odometry()?;
        self.laser.scanner()?;
        self.sights()?;
        if let Some(people) = &self.people {
            people.check()?;
        }
        if let Some(KidnapConfig { at_s, to }) = self.kidnap {
            self.steps("tour.kidnap.at_s", at_s)?;
            if at_s > self.duration_s {
                let expected = format!("a time within the {} s of the tour", self.duration_s);
                return Err(field("tour.kidnap.at_s", &expected, &at_s.to_string()));
            }
            if let KidnapTarget::Pose(pose) = to {
                pose.check("tour.kidnap.to")?;
            }
        }
        Ok(())
    }

    /// How many time steps a duration lasts.
    ///
    /// # Errors
    /// [`crate::Error::Config`] for one that is no positive multiple of the time step.
    pub(super) fn steps(&self, key: &'static str, duration: f64) -> Result<usize> {
        positive(key, duration)?;
        let steps = duration / self.time_step_s;
        let whole = steps.round();
        if whole < 1.0 || (steps - whole).abs() > 1e-6 * whole || whole > 1e7 {
            let expected = format!("a multiple of the time step {} s", self.time_step_s);
            return Err(field(key, &expected, &duration.to_string()));
        }
        // Checked to be a whole number between 1 and 1e7.
        Ok(whole as usize)
    }

    /// Standard deviations of (x, y, heading) at the start \[m, m, rad\].
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for negative ones.
    pub(super) fn start_sigmas(&self) -> Result<[f64; 3]> {
        let position = non_negative("tour.start_sigma.position_m", self.start_sigma.position_m)?;
        let heading = non_negative("tour.start_sigma.heading_deg", self.start_sigma.heading_deg)?;
        Ok([position, position, heading.to_radians()])
    }

    /// The simulated odometry.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub(super) fn odometry(&self) -> Result<WheelOdometry> {
        let odometry = WheelOdometry::new(self.wheels.track_m)?.with_noise(self.wheel_noise()?);
        Ok(odometry.with_faults(self.wheels.faults)?)
    }

    /// What a method among landmarks is told unless a filter section says otherwise: the truth.
    ///
    /// # Errors
    /// [`crate::Error::Config`] and [`loc_core::Error::OutOfRange`] with the key.
    pub(crate) fn sights(&self) -> Result<RobotSettings> {
        let settings = RobotSettings::default().odometry(self.wheel_noise()?);
        let Some(camera) = &self.camera else { return Ok(settings) };
        self.steps("tour.camera.every_s", camera.every_s)?;
        if camera.latency_s > 0.0 {
            let found = camera.latency_s.to_string();
            return Err(field(
                "tour.camera.latency_s",
                "0, as late results are for a drive",
                &found,
            ));
        }
        let LandmarkCamera { mounting, noise, .. } = camera.camera()?;
        Ok(settings.mounting(mounting).camera(noise))
    }

    /// Random errors of the wheels.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    fn wheel_noise(&self) -> Result<VelocityNoise> {
        self.wheels.noise.map_or(Ok(VelocityNoise::NONE), |noise| noise.noise())
    }
}

impl PoseConfig {
    /// The library's form.
    pub fn pose(&self) -> Pose2 {
        Pose2::new(self.x_m, self.y_m, self.heading_deg.to_radians())
    }

    /// Lets finite numbers pass.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] with the key.
    pub(crate) fn check(&self, key: &'static str) -> Result<()> {
        for value in [self.x_m, self.y_m, self.heading_deg] {
            finite(key, value)?;
        }
        Ok(())
    }
}
