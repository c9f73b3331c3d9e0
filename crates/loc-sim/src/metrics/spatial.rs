//! Trajectories in space, the pairing of their poses by stamp, and their alignment.
//!
//! A method without a map starts in a frame of its own, so its path may have the right shape at
//! another pose. An alignment is the one rigid transform that carries the estimate into the frame
//! of the reference before the errors are measured. It hides errors too: a method that localizes
//! in a given map is evaluated without one.
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
//!
//! Two trajectories of one drive rarely have the same stamps: the reference may come at 100 Hz,
//! the estimate at 7 Hz. [`associate`] pairs each pose of the shorter trajectory with the one of
//! the longer that is nearest in time, unless even that one is too far away.
//!
//! ```
//! use loc_sim::metrics::associate;
//! let (estimate, reference) = ([0.0, 1.004, 2.5], [0.0, 0.5, 1.0, 1.5, 2.0]);
//! assert_eq!(associate(&estimate, &reference, 0.01), [(0, 0), (1, 2)]);
//! ```

use crate::Result;
use loc_core::nalgebra::{Isometry3, Quaternion, Rotation2, UnitQuaternion, Vector2, Vector3};
use loc_core::table::{Row, Table};
use loc_core::{Error, Pose2, Stamped, Trajectory};
use std::path::Path;

const COLUMNS: [&str; 8] = ["timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw"];

/// The shortest quaternion that still has a direction.
const SHORTEST_QUATERNION: f64 = 3e-8;

/// Poses in space in order of time, with a name for error messages.
///
/// Robots in the plane have a [`Trajectory`], which converts into this. Recordings of a handheld
/// camera or a flying robot need the third dimension.
#[derive(Debug, Clone, PartialEq)]
pub struct SpatialTrajectory {
    name: String,
    poses: Vec<Stamped<Isometry3<f64>>>,
}

impl SpatialTrajectory {
    /// A trajectory without poses.
    pub fn new(name: impl Into<String>) -> Self {
        SpatialTrajectory { name: name.into(), poses: Vec::new() }
    }

    /// Reads a TUM file, `timestamp tx ty tz qx qy qz qw` a line. Quaternions need not be of unit
    /// length.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Parse`] with line and column, also for stamps that run backwards
    /// and for quaternions of length 0; [`Error::Empty`] for a file without poses.
    pub fn read_tum(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(Error::io(path))?;
        SpatialTrajectory::parse_tum(path, &text)
    }

    /// The same over a text in memory; `path` is only named in errors.
    ///
    /// # Errors
    /// Those of [`SpatialTrajectory::read_tum`], without [`Error::Io`].
    pub fn parse_tum(path: impl AsRef<Path>, text: &str) -> Result<Self> {
        let path = path.as_ref();
        let table = Table::parse(path, text, &COLUMNS);
        let mut trajectory = SpatialTrajectory::new(path.display().to_string());
        for row in table.rows() {
            let row = row?;
            let stamp = row.number("timestamp")?;
            if trajectory.last_stamp().is_some_and(|last| last > stamp) {
                let expected = "a stamp not before the last one";
                return Err(row.error("timestamp", expected, row.text("timestamp")?).into());
            }
            trajectory.push(stamp, pose(&row)?)?;
        }
        if trajectory.poses.is_empty() {
            return Err(Error::Empty { file: path.to_owned(), what: "poses" }.into());
        }
        Ok(trajectory)
    }

    /// Appends a pose.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for numbers that are not finite, [`Error::TimeBackwards`] for a
    /// stamp \[s\] before the last one.
    pub fn push(&mut self, stamp: f64, pose: Isometry3<f64>) -> Result<()> {
        loc_core::error::finite("trajectory stamp [s]", stamp)?;
        for &value in pose.translation.vector.iter().chain(&pose.rotation.coords) {
            loc_core::error::finite("trajectory pose", value)?;
        }
        if let Some(before) = self.last_stamp().filter(|&last| last > stamp) {
            return Err(
                Error::TimeBackwards { what: self.name.clone(), before, after: stamp }.into()
            );
        }
        self.poses.push(Stamped { stamp, value: pose });
        Ok(())
    }

    /// The name: the file, where the poses came from one.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The poses with their stamps.
    pub fn poses(&self) -> &[Stamped<Isometry3<f64>>] {
        &self.poses
    }

    /// The stamps, in ascending order \[s\].
    pub fn stamps(&self) -> Vec<f64> {
        self.poses.iter().map(|pose| pose.stamp).collect()
    }

    fn last_stamp(&self) -> Option<f64> {
        self.poses.last().map(|pose| pose.stamp)
    }
}

impl From<&Trajectory> for SpatialTrajectory {
    /// The same poses, in the plane z = 0.
    fn from(planar: &Trajectory) -> Self {
        let lifted = |pose: &Stamped<_>| Stamped {
            stamp: pose.stamp,
            value: Isometry3::from_planar(pose.value),
        };
        SpatialTrajectory {
            name: "trajectory".to_owned(),
            poses: planar.iter().map(lifted).collect(),
        }
    }
}

fn pose(row: &Row<'_>) -> Result<Isometry3<f64>> {
    let position = Vector3::new(row.number("tx")?, row.number("ty")?, row.number("tz")?);
    let (x, y, z) = (row.number("qx")?, row.number("qy")?, row.number("qz")?);
    let quaternion = Quaternion::new(row.number("qw")?, x, y, z);
    match UnitQuaternion::try_new(quaternion, SHORTEST_QUATERNION) {
        // The square of the length of a long one is no number any more.
        Some(rotation) if quaternion.norm().is_finite() => {
            Ok(Isometry3::from_parts(position.into(), rotation))
        }
        _ => {
            let found = format!("{x} {y} {z} {}", quaternion.w);
            Err(row.error("qx", "a quaternion to be normalised", &found).into())
        }
    }
}

/// A position with an orientation, in the plane or in space.
///
/// The errors are computed once over this trait, so that the figures of planar poses and those of
/// the same poses in space cannot differ.
pub trait RigidPose: Copy {
    /// A pose of the plane z = 0.
    fn from_planar(pose: Pose2) -> Self;

    /// The position \[m\]; z = 0 in the plane.
    fn position(self) -> Vector3<f64>;

    /// The angle of the rotation, in \[0, pi\] \[rad\].
    fn rotation_angle(self) -> f64;

    /// This pose followed by `other`, which is given in this pose's frame.
    #[must_use]
    fn compose(self, other: Self) -> Self;

    /// The pose that undoes this one.
    #[must_use]
    fn inverse(self) -> Self;

    /// `other` as seen from this pose.
    #[must_use]
    fn between(self, other: Self) -> Self;
}

impl RigidPose for Pose2 {
    fn from_planar(pose: Pose2) -> Self {
        pose
    }
    fn position(self) -> Vector3<f64> {
        Vector3::new(self.x, self.y, 0.0)
    }
    fn rotation_angle(self) -> f64 {
        loc_core::angle::wrap(self.theta).abs()
    }
    fn compose(self, other: Self) -> Self {
        Pose2::compose(self, other)
    }
    fn inverse(self) -> Self {
        Pose2::inverse(self)
    }
    fn between(self, other: Self) -> Self {
        Pose2::between(self, other)
    }
}

impl RigidPose for Isometry3<f64> {
    fn from_planar(pose: Pose2) -> Self {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), pose.theta);
        Isometry3::from_parts(Vector3::new(pose.x, pose.y, 0.0).into(), turn)
    }
    fn position(self) -> Vector3<f64> {
        self.translation.vector
    }
    fn rotation_angle(self) -> f64 {
        self.rotation.angle()
    }
    fn compose(self, other: Self) -> Self {
        self * other
    }
    fn inverse(self) -> Self {
        Isometry3::inverse(&self)
    }
    fn between(self, other: Self) -> Self {
        self.inv_mul(&other)
    }
}

/// How the estimate is aligned with the frame of the reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Alignment {
    /// No alignment: both are given in the same frame.
    #[default]
    None,
    /// The poses of the first pair coincide, position and orientation.
    Origin,
    /// Rotation about z and translation in x and y, by least squares of the positions.
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

/// The pose of the estimate's frame in the reference's; `None` where the two are the same.
///
/// # Errors
/// [`crate::Error::UndeterminedAlignment`] where the positions do not determine the rotation of
/// [`Alignment::Se2`], such as those of a robot at rest.
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
    let undetermined = crate::Error::UndeterminedAlignment { pairs: pairs.len() };
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

/// An estimated and a reference pose of the same time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair<P> {
    /// The estimated pose.
    pub estimate: P,
    /// The reference pose.
    pub reference: P,
}

impl<P> Pair<P> {
    /// A pair of poses.
    pub fn new(estimate: P, reference: P) -> Self {
        Pair { estimate, reference }
    }
}

/// The pairs (index of the estimate, index of the reference) of stamps that lie at most `max_dt`
/// \[s\] apart.
///
/// Both lists are in ascending order \[s\]. The rules are those of evo 1.38: the shorter list is
/// walked through (the estimate, where both are of one length), and each of its stamps takes the
/// nearest of the longer list. One stamp of the longer list may be taken several times. Of two
/// that are equally near, the earlier is taken; of several equal ones behind, the last, and of
/// several equal ones ahead, the first. (Older versions of evo, such as 1.31, take the first of equal
/// ones always, so their figures differ where the longer list repeats stamps.)
pub fn associate(estimate: &[f64], reference: &[f64], max_dt: f64) -> Vec<(usize, usize)> {
    if estimate.len() > reference.len() {
        let taken = |(i, &stamp)| Some((nearest(stamp, estimate, max_dt)?, i));
        reference.iter().enumerate().filter_map(taken).collect()
    } else {
        let taken = |(i, &stamp)| Some((i, nearest(stamp, reference, max_dt)?));
        estimate.iter().enumerate().filter_map(taken).collect()
    }
}

/// The index of the one of `stamps`, in ascending order, that is nearest to `stamp`.
fn nearest(stamp: f64, stamps: &[f64], max_dt: f64) -> Option<usize> {
    let (first, last) = (stamps.first()?, stamps.last()?);
    // Sums, where below there are differences: at the very limit the rounding decides.
    if stamp < first - max_dt || stamp > last + max_dt {
        return None;
    }
    let next = stamps.partition_point(|&other| other <= stamp);
    let next = next.min(stamps.len() - 1);
    let ahead = stamps[next] - stamp;
    let behind = match next.checked_sub(1) {
        Some(previous) => stamp - stamps[previous],
        None => f64::INFINITY,
    };
    if ahead < behind {
        (ahead <= max_dt).then_some(next)
    } else {
        (behind <= max_dt).then_some(next - 1)
    }
}
