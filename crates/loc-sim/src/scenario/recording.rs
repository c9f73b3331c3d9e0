//! The configuration of a replay: the start, the calibration of the robot's sensors, and the
//! methods.

use super::methods::FilterConfig;
use crate::localizer::MethodSettings;
use crate::{Error, Result, config};
use loc_core::error::non_negative;
use loc_filters::landmark::RobotSettings;
use loc_sensors::landmark_camera::CameraCalibration;
use loc_sensors::wheel::OdometryCalibration;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The settings that MRCLAM recordings are replayed with, as TOML.
pub const MRCLAM: &str = include_str!("../../recordings/mrclam.toml");

/// The settings that recordings with a laser are replayed with, as TOML.
pub const LASER: &str = include_str!("../../recordings/laser.toml");

/// The settings that recordings of ranges are replayed with, as TOML.
pub const RANGING: &str = include_str!("../../recordings/ranging.toml");

/// The settings that the landmark course is replayed with, as TOML.
pub const LANDMARK_COURSE: &str = include_str!("../../recordings/landmark-course.toml");

/// The settings that MRPT's demonstration of SLAM is replayed with, as TOML.
pub const KF_SLAM_DEMO: &str = include_str!("../../recordings/kf-slam-demo.toml");

/// The settings that Victoria Park is replayed with, as TOML: trees with numbers.
pub const VICTORIA_PARK: &str = include_str!("../../recordings/victoria-park.toml");

/// The same for all trunk detections, with unknown data association.
pub const VICTORIA_PARK_DETECTIONS: &str =
    include_str!("../../recordings/victoria-park-detections.toml");

/// The properties of the robot for a replay, beside its log.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RecordingConfig {
    /// Systematic errors of the odometry.
    pub odometry: OdometryCalibrationConfig,
    /// Systematic errors of the camera.
    pub camera: CameraCalibrationConfig,
    /// Settings of the methods.
    pub filter: FilterConfig,
    /// How well the start pose is known.
    pub start: StartConfig,
}

/// How well the start pose of a recording with a laser is known, as standard deviations.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StartConfig {
    /// Of both coordinates of the position.
    pub position_sigma_m: f64,
    /// Of the heading.
    pub heading_sigma_deg: f64,
}

impl Default for StartConfig {
    fn default() -> Self {
        StartConfig { position_sigma_m: 0.2, heading_sigma_deg: 5.0 }
    }
}

impl StartConfig {
    /// The standard deviations over (x, y, theta) \[m, m, rad\].
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub fn sigmas(&self) -> Result<[f64; 3]> {
        let position = non_negative("start.position_sigma_m", self.position_sigma_m)?;
        let heading = non_negative("start.heading_sigma_deg", self.heading_sigma_deg)?;
        Ok([position, position, heading.to_radians()])
    }
}

/// [`OdometryCalibration`] in the units of configuration files.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OdometryCalibrationConfig {
    /// Time until the robot does what was recorded.
    pub delay_s: f64,
    /// Factor of the forward speed.
    pub speed_scale: f64,
    /// Share of the forward speed lost per turn rate of 1 rad/s.
    pub turn_slowdown_s_per_rad: f64,
    /// Factor of the turn rate.
    pub turn_scale: f64,
    /// Curvature of the path that was meant to be straight.
    pub curvature_per_m: f64,
}

/// [`CameraCalibration`] in the units of configuration files.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CameraCalibrationConfig {
    /// Factor by which reported distances are too long.
    pub range_scale: f64,
    /// Whether distances are depths along the optical axis.
    pub range_is_depth: bool,
    /// Angle added to every direction.
    pub bearing_bias_deg: f64,
    /// Time from a sight to its stamp.
    pub delay_s: f64,
}

impl RecordingConfig {
    /// A configuration from a TOML file, with changes of the form `key.subkey=value`.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`], and [`Error::Config`] with line and key.
    pub fn read(file: &Path, changes: &[String]) -> Result<Self> {
        let text = std::fs::read_to_string(file).map_err(loc_core::Error::io(file))?;
        RecordingConfig::parse(&file.display().to_string(), &text, changes)
    }

    /// A configuration from TOML text; `file` is only named in errors.
    ///
    /// # Errors
    /// [`Error::Config`] with line and key.
    pub fn parse(file: &str, text: &str, changes: &[String]) -> Result<Self> {
        let config: RecordingConfig = config::parse(file, text, changes)?;
        let put_into_file = |error: Error| config::error(file, &error.to_string());
        config.settings().map_err(put_into_file)?;
        config.start.sigmas().map_err(put_into_file)?;
        config.odometry_calibration().check().map_err(|e| put_into_file(e.into()))?;
        config.camera_calibration().check().map_err(|e| put_into_file(e.into()))?;
        Ok(config)
    }

    /// The library's form of the odometry's calibration.
    pub fn odometry_calibration(&self) -> OdometryCalibration {
        OdometryCalibration {
            delay: self.odometry.delay_s,
            speed_scale: self.odometry.speed_scale,
            turn_slowdown: self.odometry.turn_slowdown_s_per_rad,
            turn_scale: self.odometry.turn_scale,
            curvature: self.odometry.curvature_per_m,
        }
    }

    /// The library's form of the camera's calibration.
    pub fn camera_calibration(&self) -> CameraCalibration {
        CameraCalibration {
            range_scale: self.camera.range_scale,
            range_is_depth: self.camera.range_is_depth,
            bearing_bias: self.camera.bearing_bias_deg.to_radians(),
            delay: self.camera.delay_s,
        }
    }

    /// The settings of the methods.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub fn settings(&self) -> Result<MethodSettings> {
        self.filter.methods(RobotSettings::default())
    }
}

impl Default for OdometryCalibrationConfig {
    fn default() -> Self {
        let none = OdometryCalibration::NONE;
        OdometryCalibrationConfig {
            delay_s: none.delay,
            speed_scale: none.speed_scale,
            turn_slowdown_s_per_rad: none.turn_slowdown,
            turn_scale: none.turn_scale,
            curvature_per_m: none.curvature,
        }
    }
}

impl Default for CameraCalibrationConfig {
    fn default() -> Self {
        let none = CameraCalibration::NONE;
        CameraCalibrationConfig {
            range_scale: none.range_scale,
            range_is_depth: none.range_is_depth,
            bearing_bias_deg: none.bearing_bias.to_degrees(),
            delay_s: none.delay,
        }
    }
}
