//! Places that furniture seems to divide: a row of cupboards leaves gaps that look like doors.

use super::ExtractSettings;
use super::floor::Floor;
use super::passages::{self, Passage};
use super::regions::{NONE, renumber};
use std::collections::BTreeMap;

/// Rounds of joining, at most: every round joins all that it finds.
const ROUNDS: usize = 10;

/// Joins regions between which there is more gap than `settings.openness` allows.
pub(super) fn join_open(floor: &Floor, settings: &ExtractSettings, labels: &mut [usize]) {
    for _ in 0..ROUNDS {
        let mut gaps: BTreeMap<[usize; 2], Vec<Passage>> = BTreeMap::new();
        for passage in passages::between(floor, labels, settings) {
            gaps.entry(passage.between).or_default().push(passage);
        }
        gaps.retain(|_, passages| openness(floor, passages) > settings.openness);
        if gaps.is_empty() {
            return;
        }
        let regions = labels.iter().filter(|label| **label != NONE).max().map_or(0, |max| max + 1);
        let mut becomes: Vec<usize> = (0..regions).collect();
        for [low, high] in gaps.into_keys() {
            let (a, b) = (root(&becomes, low), root(&becomes, high));
            becomes[a.max(b)] = a.min(b);
        }
        for label in labels.iter_mut().filter(|label| **label != NONE) {
            *label = root(&becomes, *label);
        }
        renumber(labels);
    }
}

fn root(becomes: &[usize], mut label: usize) -> usize {
    while becomes[label] != label {
        label = becomes[label];
    }
    label
}

/// The share of several passages in the wall from the first to the last of them; 0 for a single
/// one, which is a door.
fn openness(floor: &Floor, passages: &[Passage]) -> f64 {
    if passages.len() < 2 {
        return 0.0;
    }
    let widths: f64 = passages.iter().map(|passage| passage.width(floor)).sum();
    let apart = |a: &Passage, b: &Passage| {
        nalgebra::distance(&floor.frame.center(a.cell), &floor.frame.center(b.cell))
    };
    let pairs = passages.iter().flat_map(|a| passages.iter().map(move |b| apart(a, b)));
    let span = pairs.fold(0.0, f64::max) + widths / passages.len() as f64;
    widths / span
}
