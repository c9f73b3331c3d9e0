//! Poses in space over time, read from TUM files of any motion.

use super::RigidPose;
use crate::Result;
use loc_core::nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};
use loc_core::table::{Row, Table};
use loc_core::{Error, Stamped, Trajectory};
use std::path::Path;

const COLUMNS: [&str; 8] = ["timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw"];

/// The shortest quaternion that still has a direction.
const SHORTEST_QUATERNION: f64 = 3e-8;

/// Poses in space in order of time, with the name that errors call them by.
///
/// Robots in the plane have a [`Trajectory`], which converts into this. What a handheld camera or
/// a flying robot recorded needs the third dimension.
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
