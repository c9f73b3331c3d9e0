//! The configuration of a robot outdoors.

use crate::Result;
use crate::config::field;
use crate::source::ObservationNoiseConfig;
use crate::source::drive::{LandmarkConfig, StartConfig, WheelConfig};
use loc_core::Twist2;
use loc_core::error::{finite, non_negative, positive};
use loc_core::motion::VelocityNoise;
use loc_filters::fusion::FusionSettings;
use loc_filters::landmark::RobotSettings;
use loc_maps::{Landmark, LandmarkMap};
use loc_sensors::compass::{Compass, CompassNoise};
use loc_sensors::gnss::GnssNoise;
use loc_sensors::imu::{ImuSpec, InertialNoise};
use loc_sensors::landmark_camera::{LandmarkCamera, ObservedKind};
use serde::Deserialize;

/// A robot that drives outdoors, with any of five sensors, each at its own pace.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutdoorConfig {
    /// Step of the simulation; also the time between two samples of the inertial unit.
    pub time_step_s: f64,
    /// The start.
    #[serde(default)]
    pub start: StartConfig,
    /// The velocities that the robot is to reach, one after the other.
    pub course: Vec<CourseConfig>,
    /// How fast it speeds up and slows down.
    pub acceleration_m_s2: f64,
    /// How fast its turn rate changes.
    pub turn_acceleration_deg_s2: f64,
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
    /// How long it lasts.
    pub duration_s: f64,
    /// Forward speed.
    pub v_m_s: f64,
    /// Turn rate, counter-clockwise.
    pub omega_deg_s: f64,
}

/// When a sensor measures.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimedWheelConfig {
    /// Time between two readings.
    pub every_s: f64,
    /// Times from and to which there are none.
    #[serde(default)]
    pub silent_s: Vec<[f64; 2]>,
    /// Track, noise and faults.
    pub drive: WheelConfig,
}

/// An inertial unit in the middle of the robot; it measures at every step.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InertialConfig {
    /// Times from and to which there are no samples.
    #[serde(default)]
    pub silent_s: Vec<[f64; 2]>,
    /// Errors of each accelerometer.
    pub accelerometer: InertialNoise,
    /// Errors of each gyroscope.
    pub gyroscope: InertialNoise,
}

/// A compass.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CompassConfig {
    /// Time between two headings.
    pub every_s: f64,
    /// Times from and to which there are none.
    #[serde(default)]
    pub silent_s: Vec<[f64; 2]>,
    /// Standard deviation of a heading.
    pub sigma_deg: f64,
}

/// A satellite receiver.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SatelliteConfig {
    /// Time between two positions.
    pub every_s: f64,
    /// Time from a position to its arrival.
    #[serde(default)]
    pub latency_s: f64,
    /// Times from and to which there are none.
    #[serde(default)]
    pub silent_s: Vec<[f64; 2]>,
    /// Standard deviation of what is new with every position.
    pub white_sigma_m: f64,
    /// Standard deviation of what drifts.
    pub drift_sigma_m: f64,
    /// Time in which the drift forgets all but 1/e of itself.
    pub drift_time_s: f64,
}

/// A radio that measures distances to the landmarks within reach.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RadioConfig {
    /// Time between two rounds.
    pub every_s: f64,
    /// Times from and to which there are none.
    #[serde(default)]
    pub silent_s: Vec<[f64; 2]>,
    /// Farthest distance.
    pub max_range_m: f64,
    /// Standard deviation of a distance.
    pub sigma_m: f64,
    /// Factor by which distances are too long.
    pub scale: f64,
    /// By how much they are too long beside.
    pub offset_m: f64,
}

impl OutdoorConfig {
    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::Config`] and [`loc_core::Error::OutOfRange`] with the key.
    pub(crate) fn check(&self) -> Result<()> {
        positive("outdoor.time_step_s", self.time_step_s)?;
        positive("outdoor.acceleration_m_s2", self.acceleration_m_s2)?;
        positive("outdoor.turn_acceleration_deg_s2", self.turn_acceleration_deg_s2)?;
        if self.course.is_empty() {
            return Err(field("outdoor.course", "at least one piece", ""));
        }
        for piece in &self.course {
            self.steps("outdoor.course.duration_s", piece.duration_s)?;
            finite("outdoor.course.v_m_s", piece.v_m_s)?;
            finite("outdoor.course.omega_deg_s", piece.omega_deg_s)?;
        }
        for value in [self.start.x_m, self.start.y_m, self.start.heading_deg] {
            finite("outdoor.start", value)?;
        }
        self.start.sigmas()?;
        for (key, every) in self.paces() {
            self.steps(key, every)?;
        }
        for [from, to] in self.silences().into_iter().map(|(_, silence)| silence) {
            finite("silent_s: from", from)?;
            non_negative("silent_s: to less from", to - from)?;
        }
        let latency = self.satellites.as_ref().map_or(0.0, |receiver| receiver.latency_s);
        non_negative("outdoor.satellites.latency_s", latency)?;
        if let Some(radio) = &self.radio {
            positive("outdoor.radio.scale", radio.scale)?;
            finite("outdoor.radio.offset_m", radio.offset_m)?;
            radio.antenna()?;
        }
        self.map()?;
        self.landmark_settings()?;
        self.fusion_settings(&FusionSettings::default())?.check()?;
        Ok(())
    }

    fn paces(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let wheels = self.wheels.as_ref().map(|s| ("outdoor.wheels.every_s", s.every_s));
        let compass = self.compass.as_ref().map(|s| ("outdoor.compass.every_s", s.every_s));
        let sky = self.satellites.as_ref().map(|s| ("outdoor.satellites.every_s", s.every_s));
        let radio = self.radio.as_ref().map(|s| ("outdoor.radio.every_s", s.every_s));
        [wheels, compass, sky, radio].into_iter().flatten()
    }

    /// The times without measurements, with the sensor's name.
    pub(crate) fn silences(&self) -> Vec<(&'static str, [f64; 2])> {
        let sensors = [
            ("satellites", self.satellites.as_ref().map(|s| &s.silent_s)),
            ("wheels", self.wheels.as_ref().map(|s| &s.silent_s)),
            ("inertial unit", self.inertial.as_ref().map(|s| &s.silent_s)),
            ("compass", self.compass.as_ref().map(|s| &s.silent_s)),
            ("radio", self.radio.as_ref().map(|s| &s.silent_s)),
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
        let steps = duration / self.time_step_s;
        let whole = steps.round();
        if whole < 1.0 || (steps - whole).abs() > 1e-6 * whole || whole > 1e7 {
            let expected = format!("a multiple of the time step {} s", self.time_step_s);
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
        let planar = |l: &LandmarkConfig| Landmark::planar(l.id, l.x_m, l.y_m);
        Ok(LandmarkMap::new(self.landmarks.iter().map(planar))?)
    }

    /// The default settings of the landmark methods: the true noise.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub(crate) fn landmark_settings(&self) -> Result<RobotSettings> {
        let mut settings = RobotSettings::default();
        if let Some(wheels) = &self.wheels {
            settings.motion_noise = match wheels.drive.noise {
                Some(noise) => noise.noise()?,
                None => VelocityNoise::NONE,
            };
        }
        if let Some(radio) = &self.radio {
            settings.observation_noise = radio.antenna()?.noise;
        }
        Ok(settings)
    }

    /// The settings of `fusion`: the true noise, but not the true systematic errors.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub(crate) fn fusion_settings(&self, given: &FusionSettings) -> Result<FusionSettings> {
        let mut settings = *given;
        if let Some(inertial) = &self.inertial {
            settings.imu = inertial.spec(self.time_step_s);
        }
        if let Some(compass) = &self.compass {
            settings.compass_sigma = positive("outdoor.compass.sigma_deg", compass.sigma_deg)?;
            settings.compass_sigma = compass.sigma_deg.to_radians();
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
        Twist2::forward(self.v_m_s, self.omega_deg_s.to_radians())
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
        let sigma = self.sigma_deg.to_radians() * compass.horizontal_field;
        let compass = Compass { noise: CompassNoise { sigma, ..CompassNoise::NONE }, ..compass };
        compass.check()?;
        Ok(compass)
    }
}

impl SatelliteConfig {
    pub(super) fn noise(&self) -> GnssNoise {
        GnssNoise {
            white_sigma: self.white_sigma_m,
            drift_sigma: self.drift_sigma_m,
            drift_time: self.drift_time_s,
            vertical_factor: 1.5,
        }
    }
}

impl RadioConfig {
    /// Sees distances all around.
    pub(super) fn antenna(&self) -> Result<LandmarkCamera> {
        let noise = ObservationNoiseConfig {
            range_sigma_m: self.sigma_m,
            range_sigma_per_m: 0.0,
            bearing_sigma_deg: 1.0,
        };
        let antenna = LandmarkCamera {
            mounting: loc_core::Pose2::IDENTITY,
            fov: std::f64::consts::TAU,
            min_range: 0.0,
            max_range: self.max_range_m,
            kind: ObservedKind::Range,
            detection_probability: 1.0,
            wrong_identity_probability: 0.0,
            noise: noise.noise()?,
        };
        antenna.check()?;
        Ok(antenna)
    }
}
