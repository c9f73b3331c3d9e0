//! Simultaneous localization and mapping: a robot in a place it has no map of (I1 to I4).
//!
//! The robot draws the map while it drives, and finds itself in it at the same time. Whatever it
//! is wrong about itself it is then wrong about all landmarks alike; the covariance between them
//! says so, and when the robot comes back to a landmark that it knew early on, the correction runs
//! through the whole map. That is why the filters here keep the covariance of everything with
//! everything, once each, and why their cost grows with its size.
//!
//! * [`LinearSlam`] is the simplest case, a robot that slides without turning (I1);
//! * [`EkfSlam`] has a heading, sees distance and direction, and can do without numbers on the
//!   landmarks (I2 to I4). [`SlamLocalizer`] around it takes stamped inputs as they come.
//!
//! ```
//! use loc_core::{Gaussian, Pose2, Twist2};
//! use loc_filters::slam::{EkfSlam, SlamSettings};
//! use loc_sensors::landmark_camera::{Observed, LandmarkObservation};
//!
//! let start = Gaussian::certain(Pose2::IDENTITY.to_vector());
//! let mut slam = EkfSlam::new(start, SlamSettings::default())?;
//! let see = |range| LandmarkObservation { landmark: 7, sight: Observed::RangeBearing { range, bearing: 0.0 } };
//! slam.correct(&[see(4.0)])?;
//! slam.predict(Twist2::forward(1.0, 0.0), 1.0)?;
//! slam.correct(&[see(2.9)])?;
//! let (robot, landmark) = (slam.pose()?, slam.landmark(7)?.unwrap());
//! assert!(robot.mean.x > 1.0 && (landmark.position.mean.x - 3.95).abs() < 0.05);
//! # Ok::<(), loc_filters::Error>(())
//! ```

mod ekf;
mod linear;
mod localizer;
mod state;

pub use ekf::{
    EkfSlam, Identities, Jacobians, MapLandmark, MapSettings, SlamOutcome, SlamSettings,
    SlamVerdict,
};
pub use linear::{LinearSlam, LinearSlamSettings, RelativeObservation};
pub use localizer::SlamLocalizer;
