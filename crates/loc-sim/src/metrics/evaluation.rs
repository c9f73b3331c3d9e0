//! Absolute and relative pose errors of one trajectory against another.
//!
//! The absolute pose error (APE) compares the poses of a pair; its translation part is also known
//! as ATE, the absolute trajectory error (J. Sturm et al., A benchmark for the evaluation of RGB-D
//! SLAM systems, IROS 2012). Its rotation part is the angle between the two orientations; in the
//! plane, the absolute heading error.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_sim::metrics::{Pair, ape_rotation, ape_translation};
//! let pairs = [Pair::new(Pose2::new(3.0, 4.0, 3.1), Pose2::new(0.0, 0.0, -3.1))];
//! assert_eq!(ape_translation(&pairs), [5.0]);
//! // Across the wrap, 6.2 rad apart are 4.8 degrees apart.
//! assert!((ape_rotation(&pairs)[0] - 4.766).abs() < 1e-3);
//! ```
//!
//! The relative pose error (RPE) compares the motions from one pair to the next. It counts an
//! early error once, while the absolute error keeps it to the end of the trajectory; RPE therefore
//! measures drift (J. Sturm et al., IROS 2012). No alignment changes it. The step is always one
//! pair, as by default in `evo_rpe`, so the figures depend on the rate of the trajectories: compare
//! only those of one recording.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_sim::metrics::{Pair, rpe_translation};
//! let pair = |estimated, x| Pair::new(Pose2::new(estimated, 0.0, 0.0), Pose2::new(x, 0.0, 0.0));
//! let errors = rpe_translation(&[pair(7.0, 0.0), pair(8.0, 1.0), pair(9.25, 2.0)]);
//! assert_eq!(errors, [0.0, 0.25]);
//! ```

use super::{Alignment, Pair, RigidPose, SpatialTrajectory, aligned, associate};
use crate::{Error, Result};
use loc_core::nalgebra::Isometry3;
use serde::ser::{Serialize, SerializeStruct, Serializer};

/// How the poses of two trajectories are paired and aligned.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EvalSettings {
    /// How the estimate is aligned with the frame of the reference.
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
    /// How the estimate was aligned with the frame of the reference.
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
/// [`Alignment::Se2`] is their `-a` for motions in the plane, except that it never mirrors the
/// plane, and that positions on a straight line are sufficient.
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
        ape: Statistics::of(Unit::Metre, &ape_translation(&pairs))?,
        ape_rot: Statistics::of(Unit::Degree, &ape_rotation(&pairs))?,
        rpe_trans: relative(Unit::Metre, rpe_translation(&pairs))?,
        rpe_rot: relative(Unit::Degree, rpe_rotation(&pairs))?,
    })
}

/// The poses paired by stamp, at least one pair.
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

/// APE, translation part: distance between the two positions of each pair \[m\].
pub fn ape_translation<P: RigidPose>(pairs: &[Pair<P>]) -> Vec<f64> {
    let distance = |pair: &Pair<P>| (pair.estimate.position() - pair.reference.position()).norm();
    pairs.iter().map(distance).collect()
}

/// APE, rotation part: angle between the two orientations of each pair, in \[0, 180\] \[deg\].
pub fn ape_rotation<P: RigidPose>(pairs: &[Pair<P>]) -> Vec<f64> {
    let turn = |pair: &Pair<P>| pair.estimate.between(pair.reference).rotation_angle();
    pairs.iter().map(|pair| turn(pair).to_degrees()).collect()
}

/// RPE, translation part: length of the translation between the two motions of each step \[m\].
pub fn rpe_translation<P: RigidPose>(pairs: &[Pair<P>]) -> Vec<f64> {
    motion_errors(pairs).map(|error| error.position().norm()).collect()
}

/// RPE, rotation part: angle between the two motions of each step, in \[0, 180\] \[deg\].
pub fn rpe_rotation<P: RigidPose>(pairs: &[Pair<P>]) -> Vec<f64> {
    motion_errors(pairs).map(|error| error.rotation_angle().to_degrees()).collect()
}

/// The estimated motion relative to the true one, from each pair to the next.
fn motion_errors<P: RigidPose>(pairs: &[Pair<P>]) -> impl Iterator<Item = P> {
    pairs.windows(2).map(|step| {
        let truth = step[0].reference.between(step[1].reference);
        truth.between(step[0].estimate.between(step[1].estimate))
    })
}

/// The unit of a list of errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Lengths \[m\].
    Metre,
    /// Angles \[deg\].
    Degree,
}

impl Unit {
    /// The unit's sign.
    pub fn symbol(self) -> &'static str {
        match self {
            Unit::Metre => "m",
            Unit::Degree => "deg",
        }
    }
}

/// The figures of a list of errors, all in its unit (`sse` in the unit squared).
///
/// Serialized with the unit in every name: `rmse_m`, `rmse_deg`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Statistics {
    /// Unit of the errors.
    pub unit: Unit,
    /// Number of errors.
    pub count: usize,
    /// Root of the mean square.
    pub rmse: f64,
    /// Mean.
    pub mean: f64,
    /// Median; of an even number of errors, the mean of the middle two.
    pub median: f64,
    /// Standard deviation about the mean, over the count (not the count less one).
    pub std: f64,
    /// Smallest error.
    pub min: f64,
    /// Largest error.
    pub max: f64,
    /// Sum of the squares.
    pub sse: f64,
}

impl Statistics {
    /// The statistics of a list of errors.
    ///
    /// # Errors
    /// [`loc_core::Error::Length`] for an empty list, [`loc_core::Error::OutOfRange`] for errors
    /// that are not finite, or too large to be squared.
    pub fn of(unit: Unit, errors: &[f64]) -> Result<Self> {
        if errors.is_empty() {
            return Err(loc_core::Error::Length {
                what: "errors to sum up",
                expected: "at least 1",
                found: 0,
            }
            .into());
        }
        let count = errors.len() as f64;
        let sse = errors.iter().map(|e| e * e).sum::<f64>();
        loc_core::error::finite("sum of the squared errors", sse)?;
        let mean = errors.iter().sum::<f64>() / count;
        let scatter = errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>();

        let mut sorted = errors.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        Ok(Statistics {
            unit,
            count: errors.len(),
            rmse: (sse / count).sqrt(),
            mean,
            median: 0.5 * (sorted[(sorted.len() - 1) / 2] + sorted[sorted.len() / 2]),
            std: (scatter / count).sqrt(),
            min: sorted[0],
            max: sorted[sorted.len() - 1],
            sse,
        })
    }
}

impl Serialize for Statistics {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let [rmse, mean, median, std, min, max, sse] = match self.unit {
            Unit::Metre => ["rmse_m", "mean_m", "median_m", "std_m", "min_m", "max_m", "sse_m2"],
            Unit::Degree => {
                ["rmse_deg", "mean_deg", "median_deg", "std_deg", "min_deg", "max_deg", "sse_deg2"]
            }
        };
        let mut object = serializer.serialize_struct("Statistics", 8)?;
        object.serialize_field("count", &self.count)?;
        object.serialize_field(rmse, &self.rmse)?;
        object.serialize_field(mean, &self.mean)?;
        object.serialize_field(median, &self.median)?;
        object.serialize_field(std, &self.std)?;
        object.serialize_field(min, &self.min)?;
        object.serialize_field(max, &self.max)?;
        object.serialize_field(sse, &self.sse)?;
        object.end()
    }
}
