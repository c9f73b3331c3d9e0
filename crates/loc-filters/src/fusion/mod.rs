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

use crate::RobotSettings;
use crate::lateration::BiasPrior;
use loc_sensors::gnss::GnssNoise;
use loc_sensors::imu::ImuSpec;
use nalgebra::Point2;

loc_core::settings! {
    /// Settings of the fused filter. Of a sensor that the robot does not have, the settings
    /// do not matter.
    ///
    /// A small robot on wheels. Ranges have the bias of radio ranging out of the box: a scale known
    /// to 10 %, an offset known to 20 cm.
    #[derive(Copy)]
    pub struct FusionSettings {
        /// The robot and its sensors.
        pub robot: RobotSettings = RobotSettings::default() => check;
        /// What is known of the bias of ranges.
        pub range_bias: BiasPrior = BiasPrior { scale_sigma: 0.1, offset_sigma: 0.2 } => check;
        /// Rate and errors of the inertial unit, which sits in the middle of the robot.
        pub imu: ImuSpec = ImuSpec::default() => check;
        /// Standard deviation of the compass \[rad\].
        #[serde(with = "loc_core::settings::angle")]
        pub compass_sigma: f64 = 2_f64.to_radians() => positive;
        /// Errors of the satellite receiver.
        pub gnss: GnssNoise = GnssNoise::neo_m8() => check;
        /// Place of the satellite receiver's antenna on the robot \[m\].
        pub antenna: Point2<f64> = Point2::origin() => any;
        /// How fast the speed changes while no accelerometer measures it, as a random walk
        /// \[m/s/sqrt(s)\].
        pub speed_walk: f64 = 1.0 => positive;
        /// How fast the turn rate changes, as a random walk \[rad/s/sqrt(s)\].
        #[serde(with = "loc_core::settings::angle_per_sqrt_s")]
        pub turn_walk: f64 = 1.0 => positive;
        /// Standard deviation of the speed at the start, about 0 \[m/s\].
        pub start_speed: f64 = 0.5 => non_negative;
        /// Standard deviation of the turn rate at the start, about 0 \[rad/s\].
        #[serde(with = "loc_core::settings::angle_per_s")]
        pub start_turn: f64 = 0.5 => non_negative;
    }
}
