//! Victoria Park: a car among the trees of a park in Sydney (Guivant and Nebot, ACFR).
//!
//! Four kilometres in 26 minutes, with a laser that detects trunks, and sporadic GPS positions. Two
//! sets of observations exist. `gtsam_odometry.csv` (a motion from each of 6969 poses to the next)
//! with `gtsam_landmark_obs.csv` holds 3640 observations of 151 numbered trees.
//! `tree_detections.csv` holds all trunk detections of 7248 scans, without numbers and with many false
//! ones; its motion is `dead_reckoning.csv`, speed of the left rear
//! wheel and angle of the steering at 40 Hz. `gps.csv` holds positions, with outages and jumps.
//!
//! The scans have no times. The trunks are at rest exactly where the speed is 0 if the first scan is
//! at 21.6 s and each of the others 0.2137 s after the one before (correlation 0.9 at the
//! beginning, in the middle and at the end).

use super::{LandmarkRecording, Parts, folder_name, observations, odometry};
use crate::metrics::{Alignment, Pair, transform};
use crate::source::text::{distance, not_empty, stamp_after, whole};
use crate::{Error, Result};
use loc_core::kinematics::Ackermann;
use loc_core::motion::Integration;
use loc_core::table::Table;
use loc_core::{Pose2, Stamped, Twist2};
use loc_maps::LandmarkMap;
use loc_sensors::event::{Event, Payload, Truth};
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use std::path::Path;

/// Wheelbase \[m\].
const WHEELBASE: f64 = 2.83;
/// Distance of the measured wheel from the middle of the rear axle \[m\].
const HALF_AXLE: f64 = 0.76;
/// The laser's pose from the middle of the rear axle \[m\].
const LASER: Pose2 = Pose2 { x: 3.78, y: 0.5, theta: 0.0 };
/// Time of the first scan, and time between two scans \[s\].
const SCANS: (f64, f64) = (21.6, 0.2137);
/// Smallest time between two poses, some of which have equal stamps \[s\].
const TICK: f64 = 1e-3;
/// Largest number of scans: 60 hours.
const MAX_SCANS: u32 = 1_000_000;
/// Distance along which GPS determines the start pose \[m\].
const FIRST_SEGMENT: f64 = 100.0;

/// Which observations of the trees to use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trees {
    /// Numbered trees.
    Numbered,
    /// All trunk detections, without numbers.
    Detected,
}

/// Whether a folder looks like this recording.
pub fn is_victoria_park(folder: &Path) -> bool {
    folder.join("gtsam_landmark_obs.csv").is_file() || folder.join("tree_detections.csv").is_file()
}

impl LandmarkRecording {
    /// Opens a folder with the recording. The start aligns the first part of the
    /// odometry's path with the GPS. `sigmas` are its standard deviations over (x, y, heading)
    /// \[m, m, rad\].
    ///
    /// # Errors
    /// [`loc_core::Error`] with file, line and column; [`Error::Recording`] where the parts do not
    /// fit together.
    pub fn victoria_park(folder: impl AsRef<Path>, trees: Trees, sigmas: [f64; 3]) -> Result<Self> {
        let folder = folder.as_ref();
        let (poses, seen) = match trees {
            Trees::Numbered => read_numbered(folder)?,
            Trees::Detected => read_detected(folder)?,
        };
        let gps = read_gps(&folder.join("gps.csv"))?;
        let start = start_pose(&poses, &gps).ok_or_else(|| Error::Recording {
            path: folder.to_owned(),
            expected: "positions of the GPS along the first part of the odometry".into(),
            found: "none".into(),
        })?;
        let mut events: Vec<Event> =
            poses.iter().map(|pose| odometry(pose.stamp, pose.value)).collect();
        events.extend(seen);
        let (first, last) = (poses.first(), poses.last());
        let within = |fix: &&Stamped<Pose2>| {
            first.is_some_and(|p| fix.stamp >= p.stamp)
                && last.is_some_and(|p| fix.stamp <= p.stamp)
        };
        events.extend(gps.iter().filter(within).map(|fix| {
            Event::now(fix.stamp, Payload::Truth(Truth { pose: fix.value, speed: None }))
        }));
        let mut notes =
            vec!["the reference is a GPS with outages and jumps, and knows no heading".to_owned()];
        if trees == Trees::Detected {
            notes.push("the scans have no times; those here fit them to the odometry".into());
        }
        let parts = Parts {
            name: folder_name(folder),
            landmarks: LandmarkMap::default(),
            events,
            start,
            mounting: if trees == Trees::Detected { LASER } else { Pose2::IDENTITY },
            truth_has_heading: false,
            notes,
        };
        LandmarkRecording::new(folder, parts, sigmas)
    }
}

type Motions = (Vec<Stamped<Pose2>>, Vec<Event>);

/// The poses of the odometry and the observations from them, with numbers.
fn read_numbered(folder: &Path) -> Result<Motions> {
    let file = folder.join("gtsam_odometry.csv");
    let table =
        Table::read(&file, &["pose_from", "pose_to", "time_to_s_inferred", "dx", "dy", "dtheta"])?;
    let (mut pose, mut poses, mut last) = (Pose2::IDENTITY, Vec::new(), f64::NEG_INFINITY);
    let mut stamps = BTreeMap::new();
    for row in table.rows() {
        let row = row?;
        let time = stamp_after(&row, "time_to_s_inferred", &mut last)?;
        let stamp = poses.last().map_or(time, |p: &Stamped<Pose2>| time.max(p.stamp + TICK));
        pose = pose * Pose2::new(row.number("dx")?, row.number("dy")?, row.number("dtheta")?);
        poses.push(Stamped { stamp, value: pose });
        stamps.insert(whole(&row, "pose_to")?, stamp);
    }
    not_empty(poses.is_empty(), &file, "motions")?;
    let file = folder.join("gtsam_landmark_obs.csv");
    let table = Table::read(
        &file,
        &["pose", "landmark", "x_in_vehicle_m", "y_in_vehicle_m", "range_m", "bearing_rad"],
    )?;
    let mut groups: BTreeMap<u32, Vec<LandmarkObservation>> = BTreeMap::new();
    for row in table.rows() {
        let row = row?;
        let (pose, landmark) = (whole(&row, "pose")?, whole(&row, "landmark")?);
        let (range, bearing) = (distance(&row, "range_m")?, row.number("bearing_rad")?);
        if !stamps.contains_key(&pose) {
            let expected = "a pose that the odometry leads to";
            return Err(row.error("pose", expected, row.text("pose")?).into());
        }
        let observed = Observed::RangeBearing { range, bearing };
        groups.entry(pose).or_default().push(LandmarkObservation { landmark, observed });
    }
    not_empty(groups.is_empty(), &file, "observations")?;
    let at = |(pose, seen)| stamps.get(&pose).map(|stamp| observations(*stamp, seen));
    Ok((poses, groups.into_iter().filter_map(at).collect()))
}

/// The poses of dead reckoning at each scan, and all detections.
fn read_detected(folder: &Path) -> Result<Motions> {
    let file = folder.join("tree_detections.csv");
    let table = Table::read(&file, &["scan_index", "range_m", "bearing_rad", "diameter_m"])?;
    let mut groups: BTreeMap<u32, Vec<LandmarkObservation>> = BTreeMap::new();
    for row in table.rows() {
        let row = row?;
        // Bearings are counted from the right of the car.
        let observed = Observed::RangeBearing {
            range: distance(&row, "range_m")?,
            bearing: row.number("bearing_rad")? - FRAC_PI_2,
        };
        let scan = whole(&row, "scan_index")?;
        if scan >= MAX_SCANS {
            let expected = format!("the number of a scan below {MAX_SCANS}");
            return Err(row.error("scan_index", &expected, row.text("scan_index")?).into());
        }
        groups.entry(scan).or_default().push(LandmarkObservation { landmark: 0, observed });
    }
    not_empty(groups.is_empty(), &file, "detections")?;
    let stamp = |scan: u32| SCANS.0 + f64::from(scan) * SCANS.1;
    let scans = groups.keys().last().map_or(0, |last| last + 1);
    let stamps: Vec<f64> = (0..scans).map(stamp).collect();
    let poses = dead_reckoned(&folder.join("dead_reckoning.csv"), &stamps)?;
    let events = groups.into_iter().map(|(scan, seen)| observations(stamp(scan), seen));
    Ok((poses, events.collect()))
}

/// Dead reckoning at each of the stamps, from the origin.
fn dead_reckoned(file: &Path, stamps: &[f64]) -> Result<Vec<Stamped<Pose2>>> {
    let table = Table::read(file, &["time_s", "speed_mps", "steering_rad"])?;
    let car = Ackermann::new(WHEELBASE)?;
    let (mut pose, mut poses, mut last) = (Pose2::IDENTITY, Vec::new(), f64::NEG_INFINITY);
    let (mut now, mut twist) = (f64::NEG_INFINITY, Twist2::ZERO);
    let mut due = stamps.iter().copied().peekable();
    for row in table.rows() {
        let row = row?;
        let stamp = stamp_after(&row, "time_s", &mut last)?;
        while let Some(scan) = due.next_if(|scan| *scan <= stamp) {
            pose = Integration::ExactArc.step(pose, twist, (scan - now).clamp(0.0, f64::MAX));
            (now, _) = (scan, poses.push(Stamped { stamp: scan, value: pose }));
        }
        if now.is_finite() {
            pose = Integration::ExactArc.step(pose, twist, (stamp - now).max(0.0));
        }
        now = stamp;
        let steering = row.number("steering_rad")?;
        // The wheel at the left is slower than the middle of its axle in a turn to the left.
        let speed = row.number("speed_mps")? / (1.0 - steering.tan() * HALF_AXLE / WHEELBASE);
        twist = car.twist(speed, steering);
    }
    not_empty(!last.is_finite(), file, "speeds")?;
    poses.extend(due.map(|stamp| Stamped { stamp, value: pose }));
    Ok(poses)
}

/// Positions, as poses without a heading.
fn read_gps(file: &Path) -> Result<Vec<Stamped<Pose2>>> {
    let table = Table::read(file, &["time_s", "x_east_m", "y_north_m"])?;
    let (mut fixes, mut last) = (Vec::new(), f64::NEG_INFINITY);
    for row in table.rows() {
        let row = row?;
        let stamp = stamp_after(&row, "time_s", &mut last)?;
        fixes.push(Stamped {
            stamp,
            value: Pose2::new(row.number("x_east_m")?, row.number("y_north_m")?, 0.0),
        });
    }
    not_empty(fixes.is_empty(), file, "positions")?;
    Ok(fixes)
}

/// The pose that aligns the first part of the odometry's path with the GPS.
fn start_pose(poses: &[Stamped<Pose2>], gps: &[Stamped<Pose2>]) -> Option<Pose2> {
    let mut way = 0.0;
    let mut pairs = Vec::new();
    for pair in poses.windows(2) {
        way += pair[0].value.distance(pair[1].value);
        if way > FIRST_SEGMENT {
            break;
        }
        let during =
            |fix: &&Stamped<Pose2>| pair[0].stamp < fix.stamp && fix.stamp <= pair[1].stamp;
        pairs.extend(gps.iter().find(during).map(|fix| Pair::new(pair[1].value, fix.value)));
    }
    transform(&pairs, Alignment::Se2).ok().flatten()
}
