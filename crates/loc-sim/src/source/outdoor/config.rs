//! The configuration of a robot outdoors.

use crate::Result;
use crate::config::field;
use crate::source::StartSigma;
use crate::source::drive::{LandmarkConfig, WheelConfig};
use loc_core::error::{finite, non_negative, positive};
use loc_core::motion::VelocityNoise;
use loc_core::{Pose2, Twist2};
use loc_filters::RobotSettings;
use loc_filters::fusion::FusionSettings;
use loc_maps::{Landmark, LandmarkMap};
use loc_sensors::compass::{Compass, CompassNoise};
use loc_sensors::gnss::GnssNoise;
use loc_sensors::imu::{ImuSpec, InertialNoise};
use loc_sensors::landmark_camera::{LandmarkCamera, LandmarkNoise, ObservedKind};
use serde::Deserialize;

/// A robot that drives outdoors, with any of five sensors, each at its own pace.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutdoorConfig {
    /// Step of the simulation; also the time between two samples of the inertial unit \[s\].
    pub time_step: f64,
    /// The start.
    #[serde(default, with = "loc_core::settings::pose")]
    pub start: Pose2,
    /// How well the start is known.
    #[serde(default)]
    pub start_sigma: StartSigma,
    /// The velocities that the robot is to reach, one after the other.
    pub course: Vec<CourseConfig>,
    /// How fast it speeds up and slows down \[m/s^2\].
    pub acceleration: f64,
    /// How fast its turn rate changes \[rad/s^2\].
    #[serde(with = "loc_core::settings::angle_per_s2")]
    pub turn_acceleration: f64,
    /// The wheels.
    pub wheels: Option<TimedWheelConfig>,
    /// The inertial unit.
    pub inertial: Option<InertialConfig>,
    /// The compass.
    pub compass: Option<CompassConfig>,
    /// The satellite receiver.
    pub satellites: Option<SatelliteConfig>,
    /// The radio that measures the distances to the landmarks.
    pub radio: Option<RadioConfig>,
    /// The landmarks.
    #[serde(default)]
    pub landmarks: Vec<LandmarkConfig>,
}

/// A piece of the course.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CourseConfig {
    /// How long it lasts \[s\].
    pub duration: f64,
    /// Forward speed \[m/s\].
    pub v: f64,
    /// Turn rate, counter-clockwise \[rad/s\].
    #[serde(with = "loc_core::settings::angle_per_s")]
    pub omega: f64,
}

/// When a sensor measures.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimedWheelConfig {
    /// Time between two readings \[s\].
    pub every: f64,
    /// Times from and to which there are none \[s\].
    #[serde(default)]
    pub silent: Vec<[f64; 2]>,
    /// Track, noise and faults.
    pub drive: WheelConfig,
}

/// An inertial unit in the middle of the robot; it measures at every step.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InertialConfig {
    /// Times from and to which there are no samples \[s\].
    #[serde(default)]
    pub silent: Vec<[f64; 2]>,
    /// Errors of each accelerometer.
    pub accelerometer: InertialNoise,
    /// Errors of each gyroscope.
    pub gyroscope: InertialNoise,
}

/// A compass.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CompassConfig {
    /// Time between two headings \[s\].
    pub every: f64,
    /// Times from and to which there are none \[s\].
    #[serde(default)]
    pub silent: Vec<[f64; 2]>,
    /// Standard deviation of a heading \[rad\].
    #[serde(with = "loc_core::settings::angle")]
    pub sigma: f64,
}

/// A satellite receiver.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SatelliteConfig {
    /// Time between two positions \[s\].
    pub every: f64,
    /// Time from a position to its arrival \[s\].
    #[serde(default)]
    pub latency: f64,
    /// Times from and to which there are none \[s\].
    #[serde(default)]
    pub silent: Vec<[f64; 2]>,
    /// Standard deviation of what is new with every position \[m\].
    pub white_sigma: f64,
    /// Standard deviation of what drifts \[m\].
    pub drift_sigma: f64,
    /// Time in which the drift forgets all but 1/e of itself \[s\].
    pub drift_time: f64,
}

/// A radio that measures distances to the landmarks within reach.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RadioConfig {
    /// Time between two rounds \[s\].
    pub every: f64,
    /// Times from and to which there are none \[s\].
    #[serde(default)]
    pub silent: Vec<[f64; 2]>,
    /// Farthest distance \[m\].
    pub max_range: f64,
    /// Standard deviation of a distance \[m\].
    pub sigma: f64,
    /// Factor by which distances are too long.
    pub scale: f64,
    /// By how much they are too long beside \[m\].
    pub offset: f64,
}

impl OutdoorConfig {
    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::Config`] and [`loc_core::Error::OutOfRange`] with the key.
    pub(crate) fn check(&self) -> Result<()> {
        positive("outdoor.time_step", self.time_step)?;
        positive("outdoor.acceleration", self.acceleration)?;
        positive("outdoor.turn_acceleration", self.turn_acceleration)?;
        if self.course.is_empty() {
            return Err(field("outdoor.course", "at least one piece", ""));
        }
        for piece in &self.course {
            self.steps("outdoor.course.duration", piece.duration)?;
            finite("outdoor.course.v", piece.v)?;
            finite("outdoor.course.omega", piece.omega)?;
        }
        self.start.check()?;
        self.start_sigma.sigmas()?;
        for (key, every) in self.paces() {
            self.steps(key, every)?;
        }
        for [from, to] in self.silences().into_iter().map(|(_, silence)| silence) {
            finite("silent: from", from)?;
            non_negative("silent: to less from", to - from)?;
        }
        if let Some(receiver) = &self.satellites {
            positive("outdoor.satellites.white_sigma", receiver.white_sigma)?;
        }
        let latency = self.satellites.as_ref().map_or(0.0, |receiver| receiver.latency);
        non_negative("outdoor.satellites.latency", latency)?;
        if let Some(radio) = &self.radio {
            positive("outdoor.radio.scale", radio.scale)?;
            finite("outdoor.radio.offset", radio.offset)?;
            radio.antenna()?;
        }
        self.map()?;
        self.robot()?;
        self.fusion(FusionSettings::default())?.check()?;
        Ok(())
    }

    fn paces(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let wheels = self.wheels.as_ref().map(|s| ("outdoor.wheels.every", s.every));
        let compass = self.compass.as_ref().map(|s| ("outdoor.compass.every", s.every));
        let sky = self.satellites.as_ref().map(|s| ("outdoor.satellites.every", s.every));
        let radio = self.radio.as_ref().map(|s| ("outdoor.radio.every", s.every));
        [wheels, compass, sky, radio].into_iter().flatten()
    }

    /// The times without measurements, with the sensor's name.
    pub(crate) fn silences(&self) -> Vec<(&'static str, [f64; 2])> {
        let sensors = [
            ("satellites", self.satellites.as_ref().map(|s| &s.silent)),
            ("wheels", self.wheels.as_ref().map(|s| &s.silent)),
            ("inertial unit", self.inertial.as_ref().map(|s| &s.silent)),
            ("compass", self.compass.as_ref().map(|s| &s.silent)),
            ("radio", self.radio.as_ref().map(|s| &s.silent)),
        ];
        let all = sensors.into_iter().flat_map(|(name, silences)| {
            silences.into_iter().flatten().map(move |silence| (name, *silence))
        });
        all.collect()
    }

    /// How many time steps a duration lasts.
    ///
    /// # Errors
    /// [`crate::Error::Config`] for one that is no positive multiple of the time step.
    pub(crate) fn steps(&self, key: &'static str, duration: f64) -> Result<usize> {
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

    /// The landmarks as a map.
    ///
    /// # Errors
    /// [`loc_maps::Error`] for a number that occurs twice.
    pub(crate) fn map(&self) -> Result<LandmarkMap> {
        let planar = |l: &LandmarkConfig| Landmark::planar(l.id, l.x, l.y);
        Ok(LandmarkMap::new(self.landmarks.iter().map(planar))?)
    }

    /// The default settings of the landmark methods: the true noise.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub(crate) fn robot(&self) -> Result<RobotSettings> {
        let mut settings = RobotSettings::default();
        if let Some(wheels) = &self.wheels {
            settings.odometry = wheels.drive.noise.unwrap_or(VelocityNoise::NONE);
        }
        if let Some(radio) = &self.radio {
            settings.camera = radio.antenna()?.noise;
        }
        Ok(settings)
    }

    /// The settings of `fusion`: the true noise, but not the true systematic errors.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub(crate) fn fusion(&self, mut settings: FusionSettings) -> Result<FusionSettings> {
        if let Some(inertial) = &self.inertial {
            settings.imu = inertial.spec(self.time_step);
        }
        if let Some(compass) = &self.compass {
            settings.compass_sigma = positive("outdoor.compass.sigma", compass.sigma)?;
        }
        if let Some(satellites) = &self.satellites {
            settings.gnss = satellites.noise();
        }
        Ok(settings)
    }
}

impl CourseConfig {
    /// The velocity.
    pub(super) fn twist(&self) -> Twist2 {
        Twist2::forward(self.v, self.omega)
    }
}

impl InertialConfig {
    pub(super) fn spec(&self, time_step: f64) -> ImuSpec {
        let InertialConfig { accelerometer, gyroscope, .. } = *self;
        ImuSpec { rate: 1.0 / time_step, accelerometer, gyroscope }
    }
}

impl CompassConfig {
    pub(super) fn compass(&self) -> Result<Compass> {
        let compass = Compass::default();
        let sigma = self.sigma * compass.horizontal_field;
        let compass = Compass { noise: CompassNoise { sigma, ..CompassNoise::NONE }, ..compass };
        compass.check()?;
        Ok(compass)
    }
}

impl SatelliteConfig {
    pub(super) fn noise(&self) -> GnssNoise {
        GnssNoise {
            white_sigma: self.white_sigma,
            drift_sigma: self.drift_sigma,
            drift_time: self.drift_time,
            vertical_factor: 1.5,
        }
    }
}

impl RadioConfig {
    /// Sees distances all around.
    pub(super) fn antenna(&self) -> Result<LandmarkCamera> {
        let noise = LandmarkNoise {
            range_sigma: self.sigma,
            range_sigma_per_m: 0.0,
            bearing_sigma: 1_f64.to_radians(),
        };
        let antenna = LandmarkCamera {
            mounting: Pose2::IDENTITY,
            fov: std::f64::consts::TAU,
            min_range: 0.0,
            max_range: self.max_range,
            kind: ObservedKind::Range,
            detection_probability: 1.0,
            wrong_identity_probability: 0.0,
            noise,
        };
        antenna.check()?;
        Ok(antenna)
    }
}
