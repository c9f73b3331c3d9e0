//! The configuration of a robot with a laser in a building.

use super::{LaserConfig, RobotConfig, WorldConfig};
use crate::Result;
use crate::config::field;
use crate::source::StartSigma;
use crate::source::drive::{CameraConfig, WheelConfig};
use crate::source::people::PeopleConfig;
use loc_core::Pose2;
use loc_core::error::{finite, positive};
use loc_core::motion::VelocityNoise;
use loc_filters::RobotSettings;
use loc_sensors::landmark_camera::LandmarkCamera;
use loc_sensors::wheel::WheelOdometry;
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
    /// How long the tour lasts; a multiple of the time step \[s\].
    pub duration: f64,
    /// Time between two readings of the odometry \[s\].
    pub time_step: f64,
    /// Where it starts; anywhere where left out.
    #[serde(default, with = "loc_core::settings::pose")]
    pub start: Option<Pose2>,
    /// How well the start is known.
    #[serde(default)]
    pub start_sigma: StartSigma,
    /// Places to visit, x and y \[m\], again and again; drawn anew all the time where left out.
    #[serde(default)]
    pub stops: Vec<[f64; 2]>,
    /// What the robot can do.
    #[serde(default)]
    pub robot: RobotConfig,
    /// The wheels and their odometry.
    pub wheels: WheelConfig,
    /// The laser.
    pub laser: LaserConfig,
    /// A camera that sees the landmarks of the world.
    pub camera: Option<CameraConfig>,
    /// People who walk about and stand in the way of beams.
    pub people: Option<PeopleConfig>,
    /// The robot is kidnapped (A3).
    pub kidnap: Option<KidnapConfig>,
}

/// When and where to the robot is carried.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KidnapConfig {
    /// When; a multiple of the time step \[s\].
    pub at: f64,
    /// Where to: a pose, or `"random"` for anywhere at least 5 m away.
    pub to: KidnapTarget,
}

/// Where a robot is carried to.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum KidnapTarget {
    /// To this pose.
    Pose(#[serde(with = "loc_core::settings::pose")] Pose2),
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
        positive("tour.time_step", self.time_step)?;
        self.steps("tour.duration", self.duration)?;
        self.steps("tour.laser.every", self.laser.every)?;
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
        self.start.iter().try_for_each(Pose2::check)?;
        self.start_sigma.sigmas()?;
        self.robot.check()?;
        self.odometry()?;
        self.laser.scanner()?;
        self.robot()?;
        if let Some(people) = &self.people {
            people.check()?;
        }
        if let Some(KidnapConfig { at, to }) = self.kidnap {
            self.steps("tour.kidnap.at", at)?;
            if at > self.duration {
                let expected = format!("a time within the {} s of the tour", self.duration);
                return Err(field("tour.kidnap.at", &expected, &at.to_string()));
            }
            if let KidnapTarget::Pose(pose) = to {
                pose.check()?;
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
        let steps = duration / self.time_step;
        let whole = steps.round();
        if whole < 1.0 || (steps - whole).abs() > 1e-6 * whole || whole > 1e7 {
            let expected = format!("a multiple of the time step {} s", self.time_step);
            return Err(field(key, &expected, &duration.to_string()));
        }
        // Checked to be a whole number between 1 and 1e7.
        Ok(whole as usize)
    }

    /// The simulated odometry.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub(super) fn odometry(&self) -> Result<WheelOdometry> {
        let odometry = WheelOdometry::new(self.wheels.track)?.with_noise(self.wheel_noise());
        Ok(odometry.with_faults(self.wheels.faults)?)
    }

    /// The default robot of the methods: the true noise.
    ///
    /// # Errors
    /// [`crate::Error::Config`] and [`loc_core::Error::OutOfRange`] with the key.
    pub(crate) fn robot(&self) -> Result<RobotSettings> {
        let settings = RobotSettings::default().odometry(self.wheel_noise());
        let Some(camera) = &self.camera else { return Ok(settings) };
        self.steps("tour.camera.every", camera.every)?;
        if camera.latency > 0.0 {
            let found = camera.latency.to_string();
            return Err(field("tour.camera.latency", "0, as late results are for a drive", &found));
        }
        let LandmarkCamera { mounting, noise, .. } = camera.camera()?;
        Ok(settings.mounting(mounting).camera(noise))
    }

    /// Random errors of the wheels.
    fn wheel_noise(&self) -> VelocityNoise {
        self.wheels.noise.unwrap_or(VelocityNoise::NONE)
    }
}
