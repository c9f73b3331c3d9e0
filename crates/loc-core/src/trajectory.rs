//! Poses over time, and the TUM files that hold them.
//!
//! ```
//! use loc_core::{Pose2, Trajectory};
//! let mut path = Trajectory::new();
//! path.push(0.0, Pose2::new(0.0, 0.0, 0.0))?;
//! path.push(1.0, Pose2::new(2.0, 0.0, 0.4))?;
//! let halfway = path.interpolate(0.5, f64::INFINITY).expect("inside the time span");
//! assert!((halfway.x - 1.0).abs() < 1e-12 && (halfway.theta - 0.2).abs() < 1e-12);
//! # Ok::<(), loc_core::Error>(())
//! ```

use crate::table::{Row, Table};
use crate::{Error, Pose2, Result, angle};
use std::fmt::Write;
use std::path::Path;

/// A value with the time that it belongs to.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Stamped<T> {
    /// Time \[s\].
    pub stamp: f64,
    /// The value at that time.
    pub value: T,
}

/// Poses in order of time. Two poses may share one stamp.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Trajectory {
    poses: Vec<Stamped<Pose2>>,
}

impl Trajectory {
    /// A trajectory without poses.
    pub fn new() -> Self {
        Trajectory::default()
    }

    /// Appends a pose.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for numbers that are not finite, [`Error::TimeBackwards`] for a
    /// stamp before the last one.
    pub fn push(&mut self, stamp: f64, pose: Pose2) -> Result<()> {
        crate::error::finite("trajectory stamp [s]", stamp)?;
        for value in [pose.x, pose.y, pose.theta] {
            crate::error::finite("trajectory pose", value)?;
        }
        if let Some(last) = self.poses.last().filter(|last| last.stamp > stamp) {
            let what = "trajectory".to_owned();
            return Err(Error::TimeBackwards { what, before: last.stamp, after: stamp });
        }
        self.poses.push(Stamped { stamp, value: pose });
        Ok(())
    }

    /// The poses with their stamps.
    pub fn iter(&self) -> std::slice::Iter<'_, Stamped<Pose2>> {
        self.poses.iter()
    }

    /// Number of poses.
    pub fn len(&self) -> usize {
        self.poses.len()
    }

    /// Whether there are no poses.
    pub fn is_empty(&self) -> bool {
        self.poses.is_empty()
    }

    /// The first pose.
    pub fn first(&self) -> Option<Stamped<Pose2>> {
        self.poses.first().copied()
    }

    /// The last pose.
    pub fn last(&self) -> Option<Stamped<Pose2>> {
        self.poses.last().copied()
    }

    /// Time from the first to the last pose \[s\]; 0 without poses.
    pub fn duration(&self) -> f64 {
        match (self.poses.first(), self.poses.last()) {
            (Some(first), Some(last)) => last.stamp - first.stamp,
            _ => 0.0,
        }
    }

    /// Length of the polygon through the positions \[m\].
    pub fn path_length(&self) -> f64 {
        self.poses.windows(2).map(|pair| pair[0].value.distance(pair[1].value)).sum()
    }

    /// The pose at a time between two poses: position and heading linearly in time, the heading
    /// along the shorter turn.
    ///
    /// `None` outside the time span, and inside gaps longer than `max_gap` \[s\].
    pub fn interpolate(&self, stamp: f64, max_gap: f64) -> Option<Pose2> {
        let after = self.poses.partition_point(|pose| pose.stamp < stamp);
        let next = self.poses.get(after)?;
        if next.stamp <= stamp {
            return Some(next.value);
        }
        let before = self.poses.get(after.checked_sub(1)?)?;
        let gap = next.stamp - before.stamp;
        if gap > max_gap {
            return None;
        }
        let share = (stamp - before.stamp) / gap;
        let (a, b) = (before.value, next.value);
        Some(Pose2::new(
            a.x + share * (b.x - a.x),
            a.y + share * (b.y - a.y),
            a.theta + share * angle::difference(b.theta, a.theta),
        ))
    }

    /// Reads a TUM file of a planar motion. The height is passed over.
    ///
    /// # Errors
    /// [`Error::Io`], [`Error::Parse`] with line and column, [`Error::Empty`], and
    /// [`Error::Parse`] for a quaternion that is not a turn about z.
    pub fn read_tum(path: impl AsRef<Path>) -> Result<Self> {
        let table = Table::read(path, &COLUMNS)?;
        let mut trajectory = Trajectory::new();
        for row in table.rows() {
            let row = row?;
            let stamp = row.number("timestamp")?;
            let pose = Pose2::new(row.number("tx")?, row.number("ty")?, heading(&row)?);
            row.number("tz")?;
            let backwards = trajectory.last().is_some_and(|last| last.stamp > stamp);
            if backwards {
                return Err(row.error(
                    "timestamp",
                    "a stamp not before the last one",
                    row.text("timestamp")?,
                ));
            }
            trajectory.push(stamp, pose)?;
        }
        if trajectory.is_empty() {
            return Err(Error::Empty { file: table.file().to_owned(), what: "poses" });
        }
        Ok(trajectory)
    }

    /// The trajectory as the text of a TUM file, every number to its last digit.
    pub fn to_tum(&self) -> String {
        let mut text = String::from("# timestamp tx ty tz qx qy qz qw\n");
        for pose in &self.poses {
            let (sin, cos) = (0.5 * pose.value.theta).sin_cos();
            let Pose2 { x, y, .. } = pose.value;
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{} {x} {y} 0 0 0 {sin} {cos}", pose.stamp);
        }
        text
    }
}

impl<'a> IntoIterator for &'a Trajectory {
    type Item = &'a Stamped<Pose2>;
    type IntoIter = std::slice::Iter<'a, Stamped<Pose2>>;
    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

/// Columns of a TUM file, one pose a line.
const COLUMNS: [&str; 8] = ["timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw"];

/// Largest tilt of a quaternion out of the plane.
const LARGEST_TILT: f64 = 1e-3;

/// The turn about z of a row's quaternion \[rad\].
fn heading(row: &Row<'_>) -> Result<f64> {
    let [x, y, z, w] = ["qx", "qy", "qz", "qw"].map(|column| row.number(column));
    let (x, y, z, w) = (x?, y?, z?, w?);
    let norm = (x * x + y * y + z * z + w * w).sqrt();
    if (norm - 1.0).abs() > LARGEST_TILT || f64::hypot(x, y) > LARGEST_TILT {
        let found = format!("{x} {y} {z} {w}");
        return Err(row.error("qx", "a unit quaternion that turns about z only", &found));
    }
    Ok(2.0 * z.atan2(w))
}
