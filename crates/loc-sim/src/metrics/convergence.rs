//! When a lost method has found the robot.

use crate::record::{MethodRecord, Run};
use loc_core::angle;

/// An estimate this close to the truth has found the robot \[m\] ..
const NEAR: f64 = 0.5;

/// .. if it looks the same way \[deg\] ..
const NEAR_TURN: f64 = 10.0;

/// .. and this many further estimates do so as well, or all that remain.
const STAYS: usize = 5;

/// When a method found the robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// Time that it took \[s\].
    pub after: f64,
    /// Measurements that it used until then.
    pub updates: usize,
}

/// The first estimate from `since` \[s\] on that lies within 0.5 m and 10 deg of the truth and
/// whose next five do so too; `None` where there is none, or no truth.
///
/// Updates are the measurements that the method accepted from `since` up to that estimate.
pub fn found(run: &Run, record: &MethodRecord, since: f64) -> Option<Found> {
    let near: Vec<bool> = (0..run.truth.len())
        .map(|k| run.truth[k].stamp >= since && is_near(run, record, k))
        .collect();
    let stays = |k: usize| near[k..].iter().take(STAYS + 1).all(|near| *near);
    let at = run.truth.get((0..near.len()).find(|&k| stays(k))?)?.stamp;
    let until = record.judgements.iter().filter(|j| j.stamp >= since && j.stamp <= at);
    let updates = until.filter(|judgement| judgement.value.accepted).count();
    Some(Found { after: at - since, updates })
}

fn is_near(run: &Run, record: &MethodRecord, k: usize) -> bool {
    let (truth, Some(estimate)) = (run.truth[k].value.pose, record.estimates.get(k)) else {
        return false;
    };
    let turn = angle::difference(estimate.pose.theta, truth.theta).abs();
    estimate.pose.distance(truth) <= NEAR && turn <= NEAR_TURN.to_radians()
}

/// Whether a method knows at the end of a run where the robot is: its last six estimates lie within
/// 0.5 m and 10 deg of the truth. `None` without a truth.
pub fn ends_near(run: &Run, record: &MethodRecord) -> Option<bool> {
    let count = run.truth.len();
    let first = count.saturating_sub(STAYS + 1);
    (count > 0).then(|| (first..count).all(|k| is_near(run, record, k)))
}
