//! How far an estimated path is from the true one.
//!
//! An estimate and a reference are two lists of poses with stamps, seldom at the same times. Three
//! steps lead from them to a handful of numbers:
//!
//! 1. [`associate()`] pairs each pose of the shorter list with the nearest in time of the other;
//! 2. [`align`] moves the estimate as one rigid body, where the two live in different frames;
//! 3. [`ape`] compares the poses of a pair (is the robot where it believes to be?), [`rpe`] the
//!    motions from one pair to the next (does it drift?), and [`Statistics`] sums the errors up.
//!
//! [`evaluate`] makes all three over TUM files in space, with the figures of `evo_ape` and
//! `evo_rpe` (M. Grupp, <https://github.com/MichaelGrupp/evo>); [`planar_errors`] makes the third
//! over planar poses that are paired already.
//!
//! ```
//! use loc_core::{Pose2, Trajectory};
//! use loc_sim::metrics::{EvalSettings, SpatialTrajectory, evaluate};
//! let (mut truth, mut estimate) = (Trajectory::new(), Trajectory::new());
//! for step in 0..10 {
//!     let t = f64::from(step);
//!     truth.push(t, Pose2::new(t, 0.0, 0.0))?;
//!     estimate.push(t + 0.002, Pose2::new(t, 0.3, 0.0))?;
//! }
//! let (estimate, truth) = (SpatialTrajectory::from(&estimate), SpatialTrajectory::from(&truth));
//! let evaluation = evaluate(&estimate, &truth, &EvalSettings::default())?;
//! assert_eq!(evaluation.pairs, 10);
//! assert!((evaluation.ape.rmse - 0.3).abs() < 1e-12);
//! # Ok::<(), loc_sim::Error>(())
//! ```

pub mod align;
pub mod ape;
pub mod associate;
mod beam_fit;
pub mod consistency;
mod convergence;
mod evaluation;
mod landmarks;
mod planar;
mod rigid;
pub mod rpe;
mod spatial;
mod statistics;
mod summary;

pub use align::{Alignment, aligned, transform};
pub use associate::{Pair, associate};
pub use beam_fit::BeamFit;
pub(crate) use consistency::pose_nees_with_freedom;
pub use consistency::{Consistency, ConsistencyFigures, RunEvidence, pose_nees};
pub use convergence::{Found, ends_near, found};
pub use evaluation::{EvalSettings, Evaluation, evaluate};
pub use landmarks::{LandmarkErrors, landmark_errors};
pub use planar::{PlanarErrors, planar_errors};
pub use rigid::RigidPose;
pub use spatial::SpatialTrajectory;
pub use statistics::{Statistics, Unit};
pub use summary::{MethodSummary, Summary};
