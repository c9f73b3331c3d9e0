//! The figures of one trajectory against another.

use super::{Alignment, Pair, SpatialTrajectory, Statistics, Unit};
use super::{aligned, ape, associate, rpe};
use crate::{Error, Result};
use loc_core::nalgebra::Isometry3;

/// How two trajectories are brought together.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EvalSettings {
    /// How the estimate is carried into the frame of the reference.
    pub align: Alignment,
    /// The largest difference in time of two poses that belong together, inclusive \[s\].
    pub max_dt: f64,
}

impl Default for EvalSettings {
    /// No alignment, 0.01 s.
    fn default() -> Self {
        EvalSettings { align: Alignment::None, max_dt: 0.01 }
    }
}

/// The figures of one trajectory against another.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct Evaluation {
    /// Number of pairs of poses.
    pub pairs: usize,
    /// How the estimate was carried into the frame of the reference.
    pub align: Alignment,
    /// The largest difference in time that was allowed \[s\].
    pub max_dt_s: f64,
    /// Absolute pose error, translation part \[m\]; also known as ATE.
    pub ape: Statistics,
    /// Absolute pose error, rotation angle \[deg\]; in the plane, the size of the heading error.
    pub ape_rot: Statistics,
    /// Relative pose error from pair to pair, translation part \[m\]; `None` for a single pair.
    pub rpe_trans: Option<Statistics>,
    /// Relative pose error from pair to pair, rotation angle \[deg\]; `None` for a single pair.
    pub rpe_rot: Option<Statistics>,
}

/// Compares an estimate with a reference.
///
/// The figures are those of `evo_ape tum` and `evo_rpe tum`: `ape` and `rpe_trans` by default,
/// `ape_rot` and `rpe_rot` with `-r angle_deg`; [`Alignment::Origin`] is their `--align_origin`.
/// [`Alignment::Se2`] is their `-a` for motions in the plane, except that it never turns the plane
/// over, and that it needs no second dimension: a straight line will do.
///
/// # Errors
/// [`loc_core::Error::OutOfRange`] for a `max_dt` that is negative or not finite,
/// [`loc_core::Error::Length`] for a trajectory without poses, [`Error::NoCommonStamps`],
/// [`Error::UndeterminedAlignment`].
pub fn evaluate(
    estimate: &SpatialTrajectory,
    reference: &SpatialTrajectory,
    settings: &EvalSettings,
) -> Result<Evaluation> {
    let pairs = paired(estimate, reference, settings.max_dt)?;
    let pairs = aligned(&pairs, settings.align)?;
    let relative = |unit, errors: Vec<f64>| match errors.as_slice() {
        [] => Ok(None),
        errors => Statistics::of(unit, errors).map(Some),
    };
    Ok(Evaluation {
        pairs: pairs.len(),
        align: settings.align,
        max_dt_s: settings.max_dt,
        ape: Statistics::of(Unit::Metre, &ape::translation_errors(&pairs))?,
        ape_rot: Statistics::of(Unit::Degree, &ape::rotation_errors(&pairs))?,
        rpe_trans: relative(Unit::Metre, rpe::translation_errors(&pairs))?,
        rpe_rot: relative(Unit::Degree, rpe::rotation_errors(&pairs))?,
    })
}

/// The pairs of poses of one time, at least one.
fn paired(
    estimate: &SpatialTrajectory,
    reference: &SpatialTrajectory,
    max_dt: f64,
) -> Result<Vec<Pair<Isometry3<f64>>>> {
    loc_core::error::non_negative("max_dt [s]", max_dt)?;
    let (estimate_start, estimate_end) = span("estimate", estimate)?;
    let (reference_start, reference_end) = span("reference", reference)?;
    let indices = associate(&estimate.stamps(), &reference.stamps(), max_dt);
    if indices.is_empty() {
        return Err(Error::NoCommonStamps {
            estimate: estimate.name().to_owned(),
            estimate_start,
            estimate_end,
            reference: reference.name().to_owned(),
            reference_start,
            reference_end,
            max_dt,
        });
    }
    let (estimate, reference) = (estimate.poses(), reference.poses());
    let pair = |(e, r): (usize, usize)| Pair::new(estimate[e].value, reference[r].value);
    Ok(indices.into_iter().map(pair).collect())
}

/// The first and the last stamp \[s\].
fn span(what: &'static str, trajectory: &SpatialTrajectory) -> Result<(f64, f64)> {
    match trajectory.poses() {
        [] => Err(loc_core::Error::Length { what, expected: "at least 1 pose", found: 0 }.into()),
        [only] => Ok((only.stamp, only.stamp)),
        [first, .., last] => Ok((first.stamp, last.stamp)),
    }
}
