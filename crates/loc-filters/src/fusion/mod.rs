//! Sensor fusion: wheels, gyroscope, accelerometers, compass, satellites and landmarks in one
//! extended Kalman filter (H1).
//!
//! Each sensor measures a part of the motion, and each may stop sending. The filter has twelve states:
//! the pose, the speed and the turn rate, and the slowly varying errors of the sensors: the biases of gyroscope and accelerometers, scale and offset of
//! ranges, the drift of the satellite receiver. Between measurements it predicts to the stamp of
//! the next one, whichever sensor it comes from; a measurement with too large an innovation is
//! rejected by its gate. The variance of a state that no sensor measures grows, at its own rate.
//!
//! [`Delayed`](crate::delayed::Delayed) around it takes late measurements. Of one stamp, the kinds have
//! an order of their own, so that the result does not depend on which came first.
//!
//! ```
//! use loc_core::{Gaussian, Pose2, Twist2, gaussian::pose_belief};
//! use loc_filters::fusion::{FusedLocalizer, FusionSettings};
//! use loc_filters::{Localizer, delayed::Delayed};
//! use loc_maps::LandmarkMap;
//! use loc_sensors::event::Measurement;
//! use nalgebra::{Matrix2, Vector2};
//!
//! let start = pose_belief(Pose2::IDENTITY, [1.0, 1.0, 0.1]);
//! let robot = FusedLocalizer::new(LandmarkMap::default(), FusionSettings::default(), 0.0, start)?;
//! let mut robot = Delayed::new(robot, 2.0)?;
//! for k in 0..100 {
//!     robot.velocity(0.1 * f64::from(k), Twist2::forward(1.0, 0.0))?;
//! }
//! let satellites = Gaussian::new(Vector2::new(10.0, 0.5), Matrix2::identity() * 4.0)?;
//! robot.correct(9.85, &Measurement::Position(satellites))?;
//! assert!((robot.estimate(10.0)?.pose.x - 10.0).abs() < 0.1);
//! # Ok::<(), loc_filters::Error>(())
//! ```

mod filter;
mod models;
pub mod state;

pub use filter::FusedLocalizer;
pub use models::{
    CompassModel, DirectionModel, DistanceModel, FusedMotion, InertialModel, ObservationModel,
    PositionModel, WheelModel,
};
pub use state::FusedBelief;

use crate::lateration::BiasPrior;
use crate::{Gate, Result};
use loc_core::Pose2;
use loc_core::error::{finite, non_negative, positive};
use loc_core::motion::{Integration, VelocityNoise};
use loc_sensors::gnss::GnssNoise;
use loc_sensors::imu::ImuSpec;
use loc_sensors::landmark_camera::LandmarkNoise;
use nalgebra::Point2;

/// All that the fused filter can be told. Of a sensor that the robot does not have, the settings
/// do not matter.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct FusionSettings {
    /// Rule that turns velocities into poses.
    pub integration: Integration,
    /// How far wheel odometry may be off (E7).
    pub motion_noise: VelocityNoise,
    /// How far observations of landmarks may be off.
    pub observation_noise: LandmarkNoise,
    /// The pose of the camera or the ranging antenna on the robot, `base_from_camera`.
    pub mounting: Pose2,
    /// What is known of the bias of ranges.
    pub range_bias: BiasPrior,
    /// Rate and errors of the inertial unit, which sits in the middle of the robot.
    pub imu: ImuSpec,
    /// Standard deviation of the compass \[rad\].
    pub compass_sigma: f64,
    /// Errors of the satellite receiver.
    pub gnss: GnssNoise,
    /// Place of the satellite receiver's antenna on the robot \[m\].
    pub antenna: Point2<f64>,
    /// How fast the speed changes while no accelerometer measures it, as a random walk
    /// \[m/s/sqrt(s)\].
    pub speed_walk: f64,
    /// How fast the speed changes beside what the accelerometer measures (floors are not level)
    /// \[m/s/sqrt(s)\].
    pub slope_walk: f64,
    /// How fast the turn rate changes, as a random walk \[rad/s/sqrt(s)\].
    pub turn_walk: f64,
    /// Standard deviation of the speed at the start, about 0 \[m/s\].
    pub start_speed: f64,
    /// Standard deviation of the turn rate at the start, about 0 \[rad/s\].
    pub start_turn: f64,
    /// Share of right measurements that the gate lets pass, 1 for no gate.
    pub gate_probability: f64,
}

impl FusionSettings {
    /// Checks every value and computes the gate.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] with the name of the first that is not allowed.
    pub fn check(&self) -> Result<Gate> {
        self.motion_noise.check()?;
        self.observation_noise.check()?;
        positive("sigma of the range [m]", self.observation_noise.range_sigma)?;
        positive("sigma of the bearing [rad]", self.observation_noise.bearing_sigma)?;
        for value in [self.mounting.x, self.mounting.y, self.mounting.theta] {
            finite("mounting of the camera [m, m, rad]", value)?;
        }
        self.range_bias.check()?;
        finite("prior sigma of the range scale", self.range_bias.scale_sigma)?;
        finite("prior sigma of the range offset [m]", self.range_bias.offset_sigma)?;
        self.imu.check()?;
        positive("sigma of the compass [rad]", self.compass_sigma)?;
        self.gnss.check()?;
        positive("white sigma of a position [m]", self.gnss.white_sigma)?;
        finite("place of the satellite antenna [m]", self.antenna.x)?;
        finite("place of the satellite antenna [m]", self.antenna.y)?;
        positive("walk of the speed [m/s/sqrt(s)]", self.speed_walk)?;
        non_negative("walk of the speed on slopes [m/s/sqrt(s)]", self.slope_walk)?;
        positive("walk of the turn rate [rad/s/sqrt(s)]", self.turn_walk)?;
        non_negative("speed at the start [m/s]", self.start_speed)?;
        non_negative("turn rate at the start [rad/s]", self.start_turn)?;
        Gate::probability(self.gate_probability)
    }
}

impl Default for FusionSettings {
    /// A small robot on wheels. Ranges have the bias of radio ranging out of the box: a scale known
    /// to 10 %, an offset known to 20 cm.
    fn default() -> Self {
        FusionSettings {
            integration: Integration::ExactArc,
            motion_noise: VelocityNoise::default(),
            observation_noise: LandmarkNoise::default(),
            mounting: Pose2::IDENTITY,
            range_bias: BiasPrior { scale_sigma: 0.1, offset_sigma: 0.2 },
            imu: ImuSpec::default(),
            compass_sigma: 2_f64.to_radians(),
            gnss: GnssNoise::neo_m8(),
            antenna: Point2::origin(),
            speed_walk: 1.0,
            slope_walk: 0.02,
            turn_walk: 1.0,
            start_speed: 0.5,
            start_turn: 0.5,
            gate_probability: 0.999,
        }
    }
}
