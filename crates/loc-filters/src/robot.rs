//! What belongs to the robot: given once and used by every method.

use crate::{Gate, Result};
use loc_core::Pose2;
use loc_core::error::positive;
use loc_core::motion::{Integration, PathNoise, VelocityNoise};
use loc_sensors::landmark_camera::LandmarkNoise;

loc_core::settings! {
    /// A robot and its sensors, with defaults for a small indoor robot.
    ///
    /// Of a sensor that the robot does not have, the settings do not matter.
    #[derive(Copy)]
    pub struct RobotSettings {
        /// Rule that turns velocities into poses.
        pub integration: Integration = Integration::ExactArc => any;
        /// Noise of the odometry, for methods that measure landmarks and ranges (E7).
        pub odometry: VelocityNoise = VelocityNoise::default() => check;
        /// Noise of the odometry along a path, for methods that use scans: with slip and failures.
        pub path: PathNoise = PathNoise::default() => check;
        /// Noise of the observations of landmarks: distances of a camera or of radio ranging, and
        /// directions.
        pub camera: LandmarkNoise = LandmarkNoise::default() => check;
        /// The pose of the camera or ranging antenna on the robot, `base_from_camera`.
        #[serde(with = "loc_core::settings::pose")]
        pub mounting: Pose2 = Pose2::IDENTITY => check;
        /// Beams of the laser shorter than this are not used \[m\] (`laser_min_range`).
        pub laser_min_range: f64 = 0.0 => non_negative;
        /// Beams of the laser longer than this are not used \[m\] (`laser_max_range`).
        pub laser_max_range: f64 = 100.0 => positive;
        /// Share of right measurements that the gate lets pass, 1 for no gate.
        pub gate_probability: f64 = 0.999 => share;
        /// How late an input may arrive \[s\].
        pub horizon: f64 = 2.0 => non_negative;
    }
}

impl RobotSettings {
    /// Checks every value and computes the gate for observations of landmarks.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] with the first that is not allowed; observations need a
    /// standard deviation above 0.
    pub fn gate(&self) -> Result<Gate> {
        self.check()?;
        positive("RobotSettings.camera.range_sigma", self.camera.range_sigma)?;
        positive("RobotSettings.camera.bearing_sigma", self.camera.bearing_sigma)?;
        Gate::probability(self.gate_probability)
    }
}
