//! Localization with landmarks whose positions are known (H2).
//!
//! Odometry carries the pose on, each observation of a landmark pulls it back. [`LandmarkEkf`] is the
//! filter of the lecture page, one prediction or correction at a time; [`LandmarkLocalizer`]
//! around it takes stamped velocities and observations as they come, late ones included.
//!
//! ```
//! use loc_core::{Gaussian, Pose2, gaussian::pose_belief};
//! use loc_filters::landmark::{LandmarkEkf, LandmarkSettings};
//! use loc_maps::{Landmark, LandmarkMap};
//! use loc_sensors::landmark_camera::{Observed, LandmarkObservation};
//!
//! let map = LandmarkMap::new([Landmark::planar(1, 4.0, 0.0)])?;
//! let start = pose_belief(Pose2::IDENTITY, [0.5, 0.5, 0.1]);
//! let mut ekf = LandmarkEkf::new(start, LandmarkSettings::default())?;
//! let observation = LandmarkObservation { landmark: 1, sight: Observed::Range { range: 3.5 } };
//! let outcome = ekf.correct(&map, &observation)?;
//! assert!(outcome.accepted() && ekf.belief().mean.x > 0.4);
//! # Ok::<(), loc_filters::Error>(())
//! ```

mod ekf;
mod localizer;
mod models;
mod outcome;
mod settings;
mod smoother;

pub use ekf::{LandmarkEkf, LandmarkFilter, LandmarkUkf};
pub use localizer::LandmarkLocalizer;
pub use models::{BearingModel, RangeBearingModel, RangeModel, VelocityMotion};
pub use outcome::{Outcome, Verdict};
pub use settings::LandmarkSettings;
pub use smoother::LandmarkSmoother;
