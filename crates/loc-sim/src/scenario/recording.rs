//! The configuration of a replay: the start, the calibration of the robot's sensors, and the
//! methods.

use crate::localizer::MethodSettings;
use crate::source::StartSigma;
use crate::{Error, Result, config};
use loc_filters::RobotSettings;
use loc_sensors::landmark_camera::CameraCalibration;
use loc_sensors::wheel::OdometryCalibration;
use serde::Deserialize;
use std::path::Path;
use toml::Table;

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
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RecordingConfig {
    /// Systematic errors of the odometry.
    pub odometry: OdometryCalibration,
    /// Systematic errors of the camera.
    pub camera: CameraCalibration,
    /// Settings of the methods, a part of [`MethodSettings`].
    pub filter: Table,
    /// How well the start pose is known.
    pub start_sigma: StartSigma,
}

impl Default for RecordingConfig {
    /// A calibrated robot; start poses are known to 0.2 m and 5 degrees.
    fn default() -> Self {
        RecordingConfig {
            odometry: OdometryCalibration::NONE,
            camera: CameraCalibration::NONE,
            filter: Table::new(),
            start_sigma: StartSigma { position: 0.2, heading: 5_f64.to_radians() },
        }
    }
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
        config::check_filter(file, text, changes)?;
        let config: RecordingConfig = config::parse(file, text, changes)?;
        let put_into_file = |error: Error| config::error(file, &error.to_string());
        config.settings(RobotSettings::default()).map_err(put_into_file)?;
        config.start_sigma.sigmas().map_err(put_into_file)?;
        config.odometry.check().map_err(|e| put_into_file(e.into()))?;
        config.camera.check().map_err(|e| put_into_file(e.into()))?;
        Ok(config)
    }

    /// The settings of the methods for a robot, of which the configuration may change what it likes.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub fn settings(&self, robot: RobotSettings) -> Result<MethodSettings> {
        MethodSettings::of(robot).overlaid(&self.filter)
    }
}
