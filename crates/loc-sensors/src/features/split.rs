//! Which beams may belong to one wall: breakpoints and split.

use super::fit::{Hit, fit};
use super::{Line, LineExtractor};
use std::ops::Range;

/// Runs of beams without a gap: one ends where the next point is farther away than a wall could
/// put it that the beam meets at the grazing angle (Borges and Aldon 2004).
pub(super) fn runs(hits: &[Hit], settings: &LineExtractor, step: f64) -> Vec<Range<usize>> {
    let mut runs = Vec::new();
    let mut start = 0;
    for k in 1..=hits.len() {
        if k < hits.len() && !is_break(&hits[k - 1], &hits[k], settings, step) {
            continue;
        }
        runs.push(start..k);
        start = k;
    }
    runs
}

fn is_break(a: &Hit, b: &Hit, settings: &LineExtractor, step: f64) -> bool {
    let steps = (b.beam.index - a.beam.index) as f64;
    let turn = (steps * step).min(0.5 * settings.grazing_angle);
    let grazing = (settings.grazing_angle - turn).sin();
    let nearer = a.beam.range.min(b.beam.range);
    let noise = (a.range_variance + b.range_variance).sqrt();
    let allowed = nearer * turn.sin() / grazing + 3.0 * noise;
    steps * step > settings.max_gap || nalgebra::distance(&a.point, &b.point) > allowed
}

/// Splits a run until each part is straight, or too short to be a wall.
pub(super) fn split(
    hits: &[Hit],
    range: Range<usize>,
    settings: &LineExtractor,
    parts: &mut Vec<Range<usize>>,
) {
    // A stack of our own: the depth is that of the scan.
    let mut open = vec![range];
    while let Some(range) = open.pop() {
        let part = &hits[range.clone()];
        if part.len() < settings.min_points || is_straight(part, settings) {
            parts.push(range);
            continue;
        }
        let middle = range.start + farthest_from_chord(part);
        open.push(middle..range.end);
        open.push(range.start..middle);
    }
}

/// Whether the points scatter about a line no more than their noise and the wall's roughness
/// explain.
pub(super) fn is_straight(part: &[Hit], settings: &LineExtractor) -> bool {
    fit(part).is_some_and(|line| is_on(part, &line, settings))
}

fn is_on(part: &[Hit], line: &Line, settings: &LineExtractor) -> bool {
    let (mut sum, mut worst) = (0.0, 0.0_f64);
    for hit in part {
        let square = deviation_squared(hit, line);
        (sum, worst) = (sum + square, worst.max(square));
    }
    // The sum is chi-square distributed with as many degrees of freedom as points but two: its
    // mean, and a few standard deviations of it.
    let freedom = (part.len().saturating_sub(2)).max(1) as f64;
    let bound = freedom + settings.gate_sigmas * (2.0 * freedom).sqrt();
    sum <= bound && worst <= settings.gate_sigmas * settings.gate_sigmas
}

/// Square of a point's distance from a line in standard deviations.
pub(super) fn deviation_squared(hit: &Hit, line: &Line) -> f64 {
    line.distance(&hit.point).powi(2) / hit.variance(line.alpha)
}

/// Index of the point farthest from the straight line between the ends, never an end.
fn farthest_from_chord(part: &[Hit]) -> usize {
    let last = part.len() - 1;
    let (from, to) = (part[0].point, part[last].point);
    let across = |k: usize| (to - from).perp(&(part[k].point - from)).abs();
    (1..last).max_by(|&a, &b| across(a).total_cmp(&across(b))).unwrap_or(1).max(1)
}
