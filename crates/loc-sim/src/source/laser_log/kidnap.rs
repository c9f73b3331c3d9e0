//! A robot that is carried away: a piece of the recording is cut out.

use super::{Entry, LaserLog, What, unsuitable};
use crate::Result;
use loc_core::Pose2;

/// How far the robot is carried at least \[m\]: out of the reach of any tracking.
pub(super) const DISTANCE: f64 = 5.0;

/// Cuts a piece out of a log, from the first scan at `after` \[s\] on to the first one at least
/// [`DISTANCE`] away. That one takes the stamp and the odometry of the first that was cut out, and
/// what follows it is moved along in time and odometry: a filter sees a robot that drives on
/// undisturbed, in another place. Returns the stamp of the cut.
pub(super) fn kidnap(log: &mut LaserLog, after: f64) -> Result<f64> {
    loc_core::error::non_negative("kidnapping [s]", after)?;
    let start = log.entries.first().map_or(0.0, |entry| entry.stamp);
    let is_late = |entry: &Entry| entry.is_scan() && entry.stamp >= start + after;
    let Some(cut) = log.entries.iter().position(is_late).filter(|cut| *cut > 0) else {
        let end = log.entries.last().map_or(0.0, |entry| entry.stamp - start);
        let expected = format!("a time of kidnapping above 0 s and up to {end:.3} s, its end");
        return Err(unsuitable(log, expected, format!("{after} s")));
    };
    let places = places(&log.entries);
    let far = |(_, (entry, place)): &(usize, (&Entry, &Pose2))| {
        entry.is_scan() && place.distance(places[cut]) >= DISTANCE
    };
    let rest = log.entries.iter().zip(&places).enumerate().skip(cut);
    let Some((resume, _)) = rest.into_iter().find(far) else {
        let expected = format!("a scan at least {DISTANCE} m from where the robot is at {after} s");
        return Err(unsuitable(log, expected, "none in the rest of the recording"));
    };
    close(&mut log.entries, cut, resume);
    Ok(log.entries[cut].stamp)
}

/// Where the robot is at each entry: by the last true pose, or by odometry where there is none.
fn places(entries: &[Entry]) -> Vec<Pose2> {
    let has_truth = entries.iter().any(|entry| entry.truth().is_some());
    let mut last = Pose2::IDENTITY;
    let place = |entry: &Entry| {
        let given = if has_truth { entry.truth() } else { entry.odometry() };
        last = given.unwrap_or(last);
        last
    };
    entries.iter().map(place).collect()
}

/// Takes out the entries from `cut` up to `resume` and joins the two ends.
fn close(entries: &mut Vec<Entry>, cut: usize, resume: usize) {
    let gap = entries[resume].stamp - entries[cut].stamp;
    let odometry = |entry: &Entry| entry.odometry().unwrap_or_default();
    let carried = odometry(&entries[cut]) * odometry(&entries[resume]).inverse();
    entries.drain(cut..resume);
    for entry in &mut entries[cut..] {
        entry.stamp -= gap;
        match &mut entry.what {
            What::Odometry(pose) => *pose = carried * *pose,
            What::Scan(scan) => scan.odometry = carried * scan.odometry,
            What::Truth(_) | What::Measured(_) => {}
        }
    }
}
