//! Errors of an estimated trajectory, and whether its covariance is consistent.
//!
//! An estimate and a reference are two lists of poses with stamps, seldom at the same times. Three
//! steps lead from them to a few numbers:
//!
//! 1. [`associate()`] pairs each pose of the shorter list with the nearest in time of the other;
//! 2. [`aligned`] applies one rigid transform to the estimate, where the frames of the two differ;
//! 3. the absolute pose error ([`ape_translation`], [`ape_rotation`]) compares the poses of a pair,
//!    the relative pose error ([`rpe_translation`], [`rpe_rotation`]) the motions from one pair to
//!    the next (drift); [`Statistics`] summarizes them.
//!
//! [`evaluate`] does all three over TUM files in space, with the figures of `evo_ape` and
//! `evo_rpe` (M. Grupp, <https://github.com/MichaelGrupp/evo>); [`planar_errors`] does the third
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

pub mod claims;
pub mod consistency;
mod evaluation;
mod landmarks;
mod spatial;
mod summary;

pub use claims::{Claims, HypothesisFigures};
pub(crate) use consistency::pose_nees_with_freedom;
pub use consistency::{Consistency, ConsistencyFigures, RunEvidence, pose_nees};
pub use evaluation::{
    EvalSettings, Evaluation, Statistics, Unit, ape_rotation, ape_translation, evaluate,
    rpe_rotation, rpe_translation,
};
pub use landmarks::{LandmarkErrors, landmark_errors};
pub use spatial::{Alignment, Pair, RigidPose, SpatialTrajectory, aligned, associate, transform};
pub use summary::{
    BeamFit, Found, MethodSummary, PlanarErrors, Summary, ends_near, found, planar_errors,
};
