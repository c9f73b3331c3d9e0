//! Reference poses from a separate file.

use super::{Entry, LaserLog, unsuitable};
use crate::Result;
use loc_core::table::{Row, Table};
use loc_core::{Error, Pose2, Trajectory};
use loc_sensors::event::Payload;
use std::path::Path;

/// Tolerance by which the stamp of a message may be later than that of its reference pose \[s\]:
/// files round their stamps.
const ROUNDING: f64 = 1e-3;

/// Largest spread of a pose that is used as reference, where the file gives it \[m\].
const MAX_SPREAD: f64 = 0.3;

/// Reference poses in the map, which estimates are compared with.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Reference {
    /// The poses.
    pub poses: Trajectory,
    /// Number of poses left out, because they or later ones were too uncertain.
    pub vague: usize,
}

impl Reference {
    /// Reads a TUM file, or a CSV file whose first line names its columns: `time_s`, `x_m` and
    /// `y_m` (or `_cm`), `theta_rad` (or `_deg`). A column `spread_m` (or `_cm`) may give the
    /// uncertainty of each pose: the file then comes from a filter that had to converge first, and
    /// all up to the last pose with more than 0.3 m is left out. Other columns are ignored.
    ///
    /// # Errors
    /// [`Error::Io`], [`Error::Parse`] with line and column, [`Error::Empty`].
    pub fn read(file: &Path) -> Result<Self> {
        if file.extension().is_some_and(|extension| extension == "tum") {
            return Ok(Reference { poses: Trajectory::read_tum(file)?, vague: 0 });
        }
        let text = std::fs::read_to_string(file).map_err(Error::io(file))?;
        Reference::parse(file, &text)
    }

    /// The same from the text of a CSV file; `file` is only named in errors.
    ///
    /// # Errors
    /// As [`Reference::read`].
    pub fn parse(file: &Path, text: &str) -> Result<Self> {
        let header = text.lines().next().unwrap_or_default().trim_start_matches('#');
        // Text in brackets after the names is a comment.
        let header = header.split('(').next().unwrap_or_default();
        let columns: Vec<&str> = header.split(',').map(str::trim).collect();
        let table = Table::parse(file, text, &columns);
        let column = |quantity: &'static str, units: &[(&'static str, f64)]| {
            let named = units.iter().find(|(name, _)| columns.contains(name)).copied();
            named.ok_or_else(|| table.error(1, quantity, &names(units), &format!("`{header}`")))
        };
        let time = column("time", &[("time_s", 1.0)])?;
        let x = column("x", &[("x_m", 1.0), ("x_cm", 0.01)])?;
        let y = column("y", &[("y_m", 1.0), ("y_cm", 0.01)])?;
        let degree = 1_f64.to_radians();
        let theta = column("theta", &[("theta_rad", 1.0), ("theta_deg", degree)])?;
        let spread = column("spread", &[("spread_m", 1.0), ("spread_cm", 0.01)]).ok();
        let value =
            |row: &Row<'_>, (name, unit): (&str, f64)| Ok::<_, Error>(unit * row.number(name)?);
        let mut reference = Reference::default();
        for row in table.rows() {
            let row = row?;
            if spread.map(|spread| value(&row, spread)).transpose()?.unwrap_or(0.0) > MAX_SPREAD {
                reference.vague += 1 + reference.poses.len();
                reference.poses = Trajectory::new();
                continue;
            }
            let stamp = value(&row, time)?;
            if reference.poses.last().is_some_and(|last| last.stamp > stamp) {
                let expected = "a time not before that of the line above";
                return Err(row.error(time.0, expected, row.text(time.0)?).into());
            }
            let pose = Pose2::new(value(&row, x)?, value(&row, y)?, value(&row, theta)?);
            reference.poses.push(stamp, pose)?;
        }
        if reference.poses.is_empty() {
            return Err(Error::Empty { file: file.to_owned(), what: "poses of a reference" }.into());
        }
        Ok(reference)
    }
}

fn names(units: &[(&str, f64)]) -> String {
    let names: Vec<_> = units.iter().map(|(name, _)| *name).collect();
    format!("a column {} in the first line", names.join(" or "))
}

/// Merges the poses of a reference into a log by their stamps, in place of the log's own.
pub(super) fn merge(log: &mut LaserLog, reference: &Reference) -> Result<()> {
    let before = log.entries.first().map_or(0.0, |entry| entry.stamp);
    let after = log.entries.last().map_or(0.0, |entry| entry.stamp);
    let mut merged = Vec::with_capacity(log.entries.len() + reference.poses.len());
    let inside = |stamp: f64| stamp >= before - ROUNDING && stamp <= after + ROUNDING;
    let mut poses = reference.poses.iter().filter(|pose| inside(pose.stamp)).peekable();
    if poses.peek().is_none() {
        let expected = format!("a reference between {before} s and {after} s");
        return Err(unsuitable(log, expected, "none of its poses there"));
    }
    for mut entry in log.entries.drain(..) {
        while let Some(pose) = poses.next_if(|pose| entry.stamp > pose.stamp + ROUNDING) {
            merged.push(Entry::of_truth(pose.stamp, pose.value));
        }
        entry.payloads.retain(|payload| !matches!(payload, Payload::Truth(_)));
        if !entry.payloads.is_empty() {
            merged.push(entry);
        }
    }
    merged.extend(poses.map(|p| Entry::of_truth(p.stamp, p.value)));
    log.entries = merged;
    if reference.vague > 0 {
        let vague = reference.vague;
        log.notes.push(format!("first {vague} poses of the reference left out: not known well"));
    }
    Ok(())
}
