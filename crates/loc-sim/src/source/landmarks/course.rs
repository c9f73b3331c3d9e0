//! The landmark course of the Freiburg lectures on robot mapping: a simulated robot among nine
//! numbered landmarks.
//!
//! `sensor_data.dat` holds lines `ODOMETRY rot1 trans rot2` (a turn, a way, a turn) and
//! `SENSOR id range bearing`; the observations below a motion were made after it. `world.dat` holds
//! `id x y` for each landmark. The robot starts at the origin. Neither times nor true poses were
//! recorded: a step is taken for a second.

use super::super::ranging::columns::{not_empty, whole};
use super::{LandmarkRecording, Parts, folder_name, observations, odometry};
use crate::Result;
use loc_core::Pose2;
use loc_core::motion::OdometryMotion;
use loc_core::table::{Row, Table};
use loc_maps::{Landmark, LandmarkMap};
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use std::path::Path;

const LOG: &str = "sensor_data.dat";

/// Whether a folder looks like this recording.
pub fn is_course(folder: &Path) -> bool {
    folder.join(LOG).is_file()
}

impl LandmarkRecording {
    /// Opens a folder with the landmark course. Without `world.dat` nothing is known of the true
    /// landmarks. `sigmas` tell how well the start is known, over (x, y, heading) \[m, m, rad\].
    ///
    /// # Errors
    /// [`loc_core::Error`] with file, line and column.
    pub fn course(folder: impl AsRef<Path>, sigmas: [f64; 3]) -> Result<Self> {
        let folder = folder.as_ref();
        let file = folder.join(LOG);
        let columns = ["kind", "rot1 or id", "trans or range", "rot2 or bearing"];
        let table = Table::read(&file, &columns)?;
        let (mut pose, mut step, mut seen) = (Pose2::IDENTITY, 0_u32, Vec::new());
        let (mut events, mut below_zero) = (vec![odometry(0.0, pose)], 0);
        for row in table.rows() {
            let row = row?;
            match row.text("kind")? {
                "ODOMETRY" => {
                    if !seen.is_empty() {
                        events.push(observations(f64::from(step), std::mem::take(&mut seen)));
                    }
                    pose = motion(&row)?.apply(pose);
                    step += 1;
                    events.push(odometry(f64::from(step), pose));
                }
                "SENSOR" => {
                    let range = row.number("trans or range")?;
                    below_zero += usize::from(range < 0.0);
                    let bearing = row.number("rot2 or bearing")?;
                    let sight = Observed::RangeBearing { range: range.max(0.0), bearing };
                    seen.push(LandmarkObservation { landmark: whole(&row, "rot1 or id")?, sight });
                }
                other => return Err(row.error("kind", "ODOMETRY or SENSOR", other).into()),
            }
        }
        not_empty(step == 0, &file, "motions (ODOMETRY)")?;
        if !seen.is_empty() {
            events.push(observations(f64::from(step), seen));
        }
        let mut notes = vec!["no times were recorded: a step is taken for a second".to_owned()];
        if below_zero > 0 {
            notes.push(format!("{below_zero} distances that noise has made negative taken for 0"));
        }
        let parts = Parts {
            name: folder_name(folder),
            landmarks: read_world(&folder.join("world.dat"))?,
            events,
            start: Pose2::IDENTITY,
            mounting: Pose2::IDENTITY,
            truth_has_heading: true,
            notes,
        };
        LandmarkRecording::new(folder, parts, sigmas)
    }
}

fn motion(row: &Row<'_>) -> Result<OdometryMotion> {
    Ok(OdometryMotion {
        rot1: row.number("rot1 or id")?,
        trans: row.number("trans or range")?,
        rot2: row.number("rot2 or bearing")?,
    })
}

fn read_world(file: &Path) -> Result<LandmarkMap> {
    if !file.is_file() {
        return Ok(LandmarkMap::default());
    }
    let table = Table::read(file, &["id", "x", "y"])?;
    let mut landmarks = Vec::new();
    for row in table.rows() {
        let row = row?;
        landmarks.push(Landmark::planar(whole(&row, "id")?, row.number("x")?, row.number("y")?));
    }
    not_empty(landmarks.is_empty(), file, "landmarks")?;
    Ok(LandmarkMap::new(landmarks)?)
}
