//! What a method claims about its own estimate, and how long it was sure and wrong.
//!
//! A method is *sure and wrong* while it gives a probability below [`SURE`] of being lost (or none:
//! then its covariance is all it says), although its estimate is farther from the truth than
//! 0.5 m and five of its standard deviations, or 20 deg off.

use crate::record::{MethodRecord, Run};
use loc_core::{Pose2, angle};
use loc_filters::localizer::{Estimate, Hypothesis};
use serde::Serialize;

/// A method is sure below this probability of being lost.
pub const SURE: f64 = 0.1;

/// It is in doubt from this one on.
pub const DOUBTFUL: f64 = 0.5;

/// Position errors up to this are not called wrong \[m\] ..
const WRONG: f64 = 0.5;

/// .. nor up to this many of the claimed standard deviations.
const SIGMAS: f64 = 5.0;

/// Heading errors up to this are not called wrong \[deg\].
const WRONG_TURN: f64 = 20.0;

/// Doubtful spans with less time between them are one \[s\].
const PAUSE: f64 = 1.0;

/// What a method claimed during a run. A figure without a meaning is `None`, null in JSON.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Claims {
    /// Mean probability of being lost, over the time of the run; null for a method that gives none.
    pub lost_mean: Option<f64>,
    /// The highest one.
    pub lost_max: Option<f64>,
    /// From when to when it was [`DOUBTFUL`] or more, in seconds from the start of the run.
    pub doubtful_s: Vec<[f64; 2]>,
    /// The hypotheses at the end, the most probable first; empty for a method that has one.
    pub hypotheses: Vec<HypothesisFigures>,
    /// Time during which the method was sure and wrong; null without a truth.
    pub sure_and_wrong_s: Option<f64>,
}

/// A hypothesis in `summary.json`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct HypothesisFigures {
    /// Its probability.
    pub share: f64,
    /// Its position.
    pub x_m: f64,
    /// Its position.
    pub y_m: f64,
    /// Its heading.
    pub heading_deg: f64,
}

impl Claims {
    /// The claims of a method in a run.
    pub fn of(run: &Run, record: &MethodRecord) -> Self {
        let samples = || run.stamps.iter().zip(durations(&run.stamps)).zip(&record.estimates);
        let lost =
            || samples().filter_map(|((at, dt), e)| Some((*at - run.stamps[0], dt, e.lost?)));
        let total: f64 = lost().map(|(_, dt, _)| dt).sum();
        let mean = lost().map(|(_, dt, lost)| dt * lost).sum::<f64>() / total;
        let max = lost().map(|(_, _, lost)| lost).reduce(f64::max);
        let wrong = samples().zip(&run.truth).filter(|((_, estimate), truth)| {
            is_sure_and_wrong(estimate, truth.value.pose, run.truth_has_heading)
        });
        // The sum of no number is -0.
        let sure_and_wrong = wrong.fold(0.0, |sum, (((_, dt), _), _)| sum + dt);
        Claims {
            lost_mean: mean.is_finite().then_some(mean),
            lost_max: max,
            doubtful_s: spans(lost().filter(|(.., lost)| *lost >= DOUBTFUL)),
            hypotheses: record.hypotheses.iter().map(HypothesisFigures::from).collect(),
            sure_and_wrong_s: (!run.truth.is_empty()).then_some(sure_and_wrong),
        }
    }
}

impl From<&Hypothesis> for HypothesisFigures {
    fn from(hypothesis: &Hypothesis) -> Self {
        let Pose2 { x, y, theta } = hypothesis.belief.pose();
        let share = hypothesis.share;
        HypothesisFigures { share, x_m: x, y_m: y, heading_deg: theta.to_degrees() }
    }
}

/// Whether an estimate claims to be right and is not; see [`crate::metrics::claims`].
pub fn is_sure_and_wrong(estimate: &Estimate, truth: Pose2, has_heading: bool) -> bool {
    if estimate.lost.is_some_and(|lost| lost >= SURE) {
        return false;
    }
    let position = estimate.belief().covariance.fixed_view::<2, 2>(0, 0).into_owned();
    let sigma = position.symmetric_eigenvalues().max().max(0.0).sqrt();
    let turn = angle::difference(estimate.pose.theta, truth.theta).abs();
    estimate.pose.distance(truth) > WRONG.max(SIGMAS * sigma)
        || has_heading && turn > WRONG_TURN.to_radians()
}

/// How long each sample stands for \[s\]: until the next one.
fn durations(stamps: &[f64]) -> impl Iterator<Item = f64> {
    stamps.windows(2).map(|pair| pair[1] - pair[0]).chain([0.0])
}

/// Joins samples (time, duration, value) to spans of time.
fn spans(samples: impl Iterator<Item = (f64, f64, f64)>) -> Vec<[f64; 2]> {
    let mut spans: Vec<[f64; 2]> = Vec::new();
    for (from, duration, _) in samples {
        match spans.last_mut() {
            Some([_, end]) if from - *end <= PAUSE => *end = from + duration,
            _ => spans.push([from, from + duration]),
        }
    }
    spans
}
