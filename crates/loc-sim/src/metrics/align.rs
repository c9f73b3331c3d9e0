//! Alignment: one rigid transform that carries the estimate into the frame of the reference.
//!
//! A method that knows no map starts in a frame of its own, so that its path may have the right
//! shape in the wrong place. An alignment takes that freedom out before the errors are measured.
//! It hides errors too: a method that localizes in a given map is judged without one.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_sim::metrics::{Alignment, Pair, aligned};
//! let moved = Pose2::new(3.0, -1.0, 0.5);
//! let truth = [Pose2::IDENTITY, Pose2::new(1.0, 0.0, 0.0), Pose2::new(1.0, 1.0, 1.5)];
//! let pairs = truth.map(|pose| Pair::new(moved * pose, pose));
//! let aligned = aligned(&pairs, Alignment::Se2)?;
//! assert!(aligned.iter().all(|pair| pair.estimate.distance(pair.reference) < 1e-12));
//! # Ok::<(), loc_sim::Error>(())
//! ```

use super::{Pair, RigidPose};
use crate::{Error, Result};
use loc_core::Pose2;
use loc_core::nalgebra::{Rotation2, Vector2};

/// How the estimate is carried into the frame of the reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Alignment {
    /// Not at all: both are given in the same frame.
    #[default]
    None,
    /// Such that the first poses of the pairs coincide, position and orientation.
    Origin,
    /// By the rotation about z and the translation in x and y that bring the positions closest.
    Se2,
}

impl Alignment {
    /// The name, as it is written on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Alignment::None => "none",
            Alignment::Origin => "origin",
            Alignment::Se2 => "se2",
        }
    }
}

/// The pairs, with every estimate carried into the frame of the reference.
///
/// # Errors
/// Those of [`transform`].
pub fn aligned<P: RigidPose>(pairs: &[Pair<P>], align: Alignment) -> Result<Vec<Pair<P>>> {
    let Some(transform) = transform(pairs, align)? else {
        return Ok(pairs.to_vec());
    };
    let carried = |pair: &Pair<P>| Pair::new(transform.compose(pair.estimate), pair.reference);
    Ok(pairs.iter().map(carried).collect())
}

/// The pose of the estimate's frame in the reference's; `None` where the two are taken for one.
///
/// # Errors
/// [`Error::UndeterminedAlignment`] where [`Alignment::Se2`] meets positions that leave the
/// rotation open, such as those of a robot that stands still.
pub fn transform<P: RigidPose>(pairs: &[Pair<P>], align: Alignment) -> Result<Option<P>> {
    match (align, pairs.first()) {
        (Alignment::None, _) | (Alignment::Origin, None) => Ok(None),
        (Alignment::Origin, Some(first)) => {
            Ok(Some(first.reference.compose(first.estimate.inverse())))
        }
        (Alignment::Se2, _) => Ok(Some(P::from_planar(fit_plane(pairs)?))),
    }
}

/// The planar motion, without scale and reflection, that takes the estimate's positions closest to
/// the reference's: S. Umeyama, IEEE PAMI 13 (1991), which has a closed form in two dimensions.
fn fit_plane<P: RigidPose>(pairs: &[Pair<P>]) -> Result<Pose2> {
    let undetermined = Error::UndeterminedAlignment { pairs: pairs.len() };
    let Some(first) = pairs.first() else {
        return Err(undetermined);
    };
    // From the first pair, not from a distant origin: equal positions then differ by exactly 0.
    let shift = Pair::new(plane(first.estimate), plane(first.reference));
    let points = || {
        pairs.iter().map(|pair| {
            Pair::new(
                plane(pair.estimate) - shift.estimate,
                plane(pair.reference) - shift.reference,
            )
        })
    };
    let count = pairs.len() as f64;
    let mean_estimate = points().map(|p| p.estimate).sum::<Vector2<f64>>() / count;
    let mean_reference = points().map(|p| p.reference).sum::<Vector2<f64>>() / count;

    let (mut dot, mut cross, mut spread_estimate, mut spread_reference) = (0.0, 0.0, 0.0, 0.0);
    for point in points() {
        let (a, b) = (point.estimate - mean_estimate, point.reference - mean_reference);
        dot += a.dot(&b);
        cross += a.perp(&b);
        spread_estimate += a.norm_squared();
        spread_reference += b.norm_squared();
    }
    // At the level of rounding, the sum has no direction (NaN fails the comparison as well).
    let spread = f64::sqrt(spread_estimate) * f64::sqrt(spread_reference);
    if f64::hypot(dot, cross) > 1e-12 * spread {
        let theta = f64::atan2(cross, dot);
        let turned = Rotation2::new(theta) * (shift.estimate + mean_estimate);
        let t = shift.reference + mean_reference - turned;
        Ok(Pose2::new(t.x, t.y, theta))
    } else {
        Err(undetermined)
    }
}

fn plane<P: RigidPose>(pose: P) -> Vector2<f64> {
    pose.position().xy()
}
