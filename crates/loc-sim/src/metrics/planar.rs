//! The figures of a run: planar poses that are paired already.

use super::{Alignment, Pair, Statistics, Unit};
use super::{aligned, ape, rpe};
use crate::Result;
use loc_core::Pose2;

/// The errors of one method over one run.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct PlanarErrors {
    /// Root mean square of the distances to the truth \[m\].
    pub ate_rmse_m: f64,
    /// Median of the distances to the truth \[m\].
    pub ate_median_m: f64,
    /// Largest distance to the truth \[m\].
    pub ate_max_m: f64,
    /// Root mean square of the heading errors, each in (-180, 180] \[deg\]; `None` where no true
    /// heading is known.
    pub heading_rmse_deg: Option<f64>,
    /// Distance to the truth at the end \[m\].
    pub final_error_m: f64,
    /// Root mean square of the errors of the motion from pose to pose \[m\]; `None` for one pose.
    pub rpe_trans_rmse_m: Option<f64>,
    /// Root mean square of the errors of the turn from pose to pose \[deg\]; `None` for one pose
    /// or without true headings.
    pub rpe_rot_rmse_deg: Option<f64>,
}

impl PlanarErrors {
    /// The names of the figures.
    pub const NAMES: [&str; 7] = [
        "ate_rmse_m",
        "ate_median_m",
        "ate_max_m",
        "heading_rmse_deg",
        "final_error_m",
        "rpe_trans_rmse_m",
        "rpe_rot_rmse_deg",
    ];

    /// The figures of positions alone. What is seen from the pose before needs a heading, too.
    #[must_use]
    pub fn without_headings(self) -> Self {
        PlanarErrors {
            heading_rmse_deg: None,
            rpe_trans_rmse_m: None,
            rpe_rot_rmse_deg: None,
            ..self
        }
    }
}

/// The errors over poses that are paired one to one, in order of time.
///
/// The figures are those of [`evaluate`](super::evaluate) over the same poses.
///
/// # Errors
/// [`loc_core::Error::Length`] without pairs, [`loc_core::Error::OutOfRange`] for poses that are
/// not finite, [`crate::Error::UndeterminedAlignment`].
pub fn planar_errors(pairs: &[Pair<Pose2>], align: Alignment) -> Result<PlanarErrors> {
    let pairs = aligned(pairs, align)?;
    let distances = ape::translation_errors(&pairs);
    let position = Statistics::of(Unit::Metre, &distances)?;
    let heading = Statistics::of(Unit::Degree, &ape::rotation_errors(&pairs))?;
    let relative = |unit, errors: Vec<f64>| match errors.as_slice() {
        [] => Ok(None),
        errors => Statistics::of(unit, errors).map(|figures| Some(figures.rmse)),
    };
    Ok(PlanarErrors {
        ate_rmse_m: position.rmse,
        ate_median_m: position.median,
        ate_max_m: position.max,
        heading_rmse_deg: Some(heading.rmse),
        final_error_m: distances[distances.len() - 1],
        rpe_trans_rmse_m: relative(Unit::Metre, rpe::translation_errors(&pairs))?,
        rpe_rot_rmse_deg: relative(Unit::Degree, rpe::rotation_errors(&pairs))?,
    })
}
