//! The groups of a study as lines over the values of one setting.

use crate::study::{CONFIDENCE, Group, Results, Spread, Study};
use loc_core::stats::{RunningMoments, mean_interval, wilson_interval};

/// More lines than this in a chart nobody can tell apart; the other settings are then pooled.
const MAX_LINES: usize = 6;

/// One line: its label and the groups at each value of the setting.
pub(super) struct GroupLine<'a> {
    pub(super) label: String,
    pub(super) points: Vec<(f64, Vec<&'a Group>)>,
}

/// The lines over the k-th setting, and whether the other settings had to be pooled.
pub(super) fn lines<'a>(
    study: &Study,
    results: &'a Results,
    k: usize,
) -> (Vec<GroupLine<'a>>, bool) {
    let (axes, methods) = (study.grid().axes(), study.records().len());
    let others: usize = study.grid().cells() / axes[k].values().len();
    let pooled = others > 1 && others * methods > MAX_LINES;
    let xs = positions(study, k);
    let mut lines: Vec<GroupLine<'a>> = Vec::new();
    for (index, group) in results.groups.iter().enumerate() {
        let place = study.grid().place(index / methods);
        let mut label = group.method.clone();
        if !pooled {
            for (j, axis) in
                axes.iter().enumerate().filter(|(j, axis)| *j != k && axis.values().len() > 1)
            {
                label += &format!(", {} {}", axis.short_name(), axis.values()[place[j]]);
            }
        }
        let known = lines.iter().position(|line| line.label == label);
        let at = known.unwrap_or_else(|| {
            let points = xs.iter().map(|&x| (x, Vec::new())).collect();
            lines.push(GroupLine { label, points });
            lines.len() - 1
        });
        lines[at].points[place[k]].1.push(group);
    }
    // Values may come in any order; a line runs from left to right.
    for line in &mut lines {
        line.points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    (lines, pooled)
}

/// Where the values of the k-th setting stand: at their numbers, or one after the other.
fn positions(study: &Study, k: usize) -> Vec<f64> {
    let axis = &study.grid().axes()[k];
    axis.numbers().unwrap_or_else(|| (1..=axis.values().len()).map(|k| k as f64).collect())
}

/// A value with the range that holds the truth.
#[derive(Clone, Copy)]
pub(super) struct Ranged {
    pub(super) value: f64,
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Ranged {
    pub(super) const NONE: Ranged = Ranged { value: f64::NAN, low: f64::NAN, high: f64::NAN };

    /// A mean that cannot be negative, with its interval.
    pub(super) fn mean(moments: &RunningMoments) -> Self {
        let Some(value) = moments.mean() else { return Ranged::NONE };
        match mean_interval(moments, CONFIDENCE) {
            Ok(Some(i)) => Ranged { value, low: i.start().max(0.0), high: *i.end() },
            _ => Ranged { value, low: value, high: value },
        }
    }

    pub(super) fn scaled(self, factor: f64) -> Self {
        Ranged { value: factor * self.value, low: factor * self.low, high: factor * self.high }
    }
}

/// The share of successes, in percent.
pub(super) fn success(groups: &[&Group]) -> Ranged {
    let judged = || groups.iter().filter(|group| group.success_rate.is_some());
    let successes: u64 = judged().map(|group| group.successes).sum();
    let runs: u64 = judged().map(|group| group.judged).sum();
    match wilson_interval(successes, runs, CONFIDENCE) {
        Ok(interval) => {
            let value = successes as f64 / runs as f64;
            Ranged { value, low: *interval.start(), high: *interval.end() }.scaled(100.0)
        }
        Err(_) => Ranged::NONE,
    }
}

/// The mean of a figure over all runs of some groups.
pub(super) fn spread(groups: &[&Group], figure: fn(&Group) -> Option<Spread>) -> Ranged {
    let mut moments = RunningMoments::new();
    for spread in groups.iter().filter_map(|group| figure(group)) {
        moments.merge(&spread.moments);
    }
    Ranged::mean(&moments)
}
