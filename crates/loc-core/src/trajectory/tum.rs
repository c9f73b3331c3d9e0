//! TUM files: `timestamp tx ty tz qx qy qz qw`, one pose a line.

use super::Trajectory;
use crate::table::{Row, Table};
use crate::{Error, Pose2, Result};
use std::fmt::Write;
use std::path::Path;

const COLUMNS: [&str; 8] = ["timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw"];

/// How far a quaternion may lean out of the plane before its heading means nothing.
const LARGEST_TILT: f64 = 1e-3;

impl Trajectory {
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
