//! Which moments of a search are worth a picture.

use crate::record::Run;
use loc_core::Pose2;

/// How many moments are shown.
const FRAMES: usize = 12;
/// Spreads and errors below this are all the same \[m\].
const SMALL: f64 = 0.3;
/// How much time counts beside spread and error, which count 1 each.
const TIME: f64 = 0.5;

/// How a moment looks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    /// Since the start \[s\].
    pub(super) time: f64,
    /// Standard deviation of the position, over both axes \[m\].
    pub(super) spread: f64,
    /// Distance of the mean from the true position \[m\].
    pub(super) error: f64,
}

impl Look {
    /// How different this moment looks from another one: in time, spread and error.
    fn difference(&self, other: &Look) -> [f64; 3] {
        let ratio = |a: f64, b: f64| ((a + SMALL) / (b + SMALL)).ln().abs();
        [
            (self.time - other.time).abs(),
            ratio(self.spread, other.spread),
            ratio(self.error, other.error),
        ]
    }
}

/// The moments to show: the first, the last, and between them those that are equally different
/// from one to the next, so that most frames show what changes most.
pub(super) fn choose(moments: &[Look]) -> Vec<usize> {
    if moments.len() <= FRAMES {
        return (0..moments.len()).collect();
    }
    let steps: Vec<[f64; 3]> =
        moments.windows(2).map(|pair| pair[1].difference(&pair[0])).collect();
    let total = |k: usize| steps.iter().map(|step| step[k]).sum::<f64>().max(1e-9);
    let totals = [total(0), total(1), total(2)];
    let mut passed = vec![0.0];
    for step in &steps {
        let weighted = (0..3).map(|k| [TIME, 1.0, 1.0][k] * step[k] / totals[k]);
        passed.push(passed[passed.len() - 1] + weighted.sum::<f64>());
    }
    let all = passed[passed.len() - 1];
    let mut chosen: Vec<usize> = Vec::with_capacity(FRAMES);
    for frame in 0..FRAMES {
        let wanted = all * frame as f64 / (FRAMES - 1) as f64;
        let at = passed.partition_point(|share| *share < wanted - 1e-9);
        // Each frame another moment, and enough of them left for the others.
        let least = chosen.last().map_or(0, |last| last + 1);
        chosen.push(at.clamp(least, moments.len() - FRAMES + frame));
    }
    chosen
}

/// Where the robot was, where that is known.
pub(super) fn truth_at(run: &Run, stamp: f64) -> Option<Pose2> {
    let next = run.truth.partition_point(|truth| truth.stamp < stamp - 1e-6);
    run.truth.get(next).or(run.truth.last()).map(|truth| truth.value.pose)
}
