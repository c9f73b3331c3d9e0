//! Localization with landmarks whose positions are known (H2).
//!
//! Odometry predicts the pose, each observation of a landmark corrects it. [`LandmarkEkf`] is the
//! filter of the lecture page, one prediction or correction at a time; [`LandmarkLocalizer`]
//! around it takes time-stamped velocities and observations.
//!
//! ```
//! use loc_core::{Gaussian, Pose2, gaussian::pose_belief};
//! use loc_filters::RobotSettings;
//! use loc_filters::landmark::LandmarkEkf;
//! use loc_maps::{Landmark, LandmarkMap};
//! use loc_sensors::landmark_camera::{Observed, LandmarkObservation};
//!
//! let map = LandmarkMap::new([Landmark::planar(1, 4.0, 0.0)])?;
//! let start = pose_belief(Pose2::IDENTITY, [0.5, 0.5, 0.1]);
//! let mut ekf = LandmarkEkf::new(start, RobotSettings::default())?;
//! let observation = LandmarkObservation { landmark: 1, observed: Observed::Range { range: 3.5 } };
//! let outcome = ekf.correct(&map, &observation)?;
//! assert!(outcome.accepted() && ekf.belief().mean.x > 0.4);
//! # Ok::<(), loc_filters::Error>(())
//! ```

mod ekf;
mod localizer;

pub use ekf::{
    BearingModel, LandmarkEkf, LandmarkFilter, LandmarkUkf, RangeBearingModel, RangeModel,
    VelocityMotion,
};
pub use localizer::LandmarkLocalizer;
