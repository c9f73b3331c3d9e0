//! Which parts of a scan are one wall: merge, adopt, corners.

use super::fit::{Hit, fit};
use super::split::{deviation_squared, is_straight};
use super::{Line, LineExtractor};
use loc_core::angle;
use nalgebra::Point2;
use std::ops::Range;

/// Makes walls of the straight parts of a scan, each a list of hits in the order of the beams.
pub(super) fn assemble(
    hits: &[Hit],
    parts: &[Range<usize>],
    settings: &LineExtractor,
) -> Vec<Vec<Hit>> {
    let (large, small): (Vec<_>, Vec<_>) =
        parts.iter().cloned().partition(|part| part.len() >= settings.min_points);
    let mut walls = merge(hits, &large, settings);
    let mut loose: Vec<Hit> = small.into_iter().flat_map(|part| hits[part].to_vec()).collect();
    dissolve(&mut walls, &mut loose, settings);
    adopt(&mut walls, &loose, settings);
    settle_corners(&mut walls);
    walls
}

/// Joins neighbouring parts that are one wall, also across a gap: one that is no longer than the
/// parts, as a straight line runs through any two short pieces.
fn merge(hits: &[Hit], parts: &[Range<usize>], settings: &LineExtractor) -> Vec<Vec<Hit>> {
    let mut walls: Vec<Vec<Hit>> = Vec::new();
    for range in parts {
        let part = &hits[range.clone()];
        if let Some(last) = walls.last_mut() {
            let joint = [last.as_slice(), part].concat();
            let gap = distance(last.last(), part.first());
            let seen = distance(last.first(), last.last()) + distance(part.first(), part.last());
            if gap <= seen && is_straight(&joint, settings) {
                *last = joint;
                continue;
            }
        }
        walls.push(part.to_vec());
    }
    walls
}

/// Distance between two hits, 0 where one is missing \[m\].
fn distance(a: Option<&Hit>, b: Option<&Hit>) -> f64 {
    a.zip(b).map_or(0.0, |(a, b)| nalgebra::distance(&a.point, &b.point))
}

/// Takes out a wall whose every point lies on one of its two neighbours: the split cut it out of
/// a corner.
fn dissolve(walls: &mut Vec<Vec<Hit>>, loose: &mut Vec<Hit>, settings: &LineExtractor) {
    let mut k = 1;
    while k + 1 < walls.len() {
        let neighbours = [fit(&walls[k - 1]), fit(&walls[k + 1])];
        let is_on = |hit: &Hit, line| deviation_squared(hit, line) <= settings.gate_sigmas.powi(2);
        let explained = |hit: &Hit| neighbours.iter().flatten().any(|line| is_on(hit, line));
        let shorter = walls[k].len() < walls[k - 1].len().min(walls[k + 1].len());
        if shorter && walls[k].iter().all(explained) {
            loose.extend(walls.remove(k));
        } else {
            k += 1;
        }
    }
}

/// Gives loose points between two walls to the one they lie on, where they lengthen it by less
/// than half.
fn adopt(walls: &mut [Vec<Hit>], loose: &[Hit], settings: &LineExtractor) {
    let lines: Vec<Option<Line>> = walls.iter().map(|wall| fit(wall)).collect();
    let firsts: Vec<usize> =
        walls.iter().map(|wall| wall.first().map_or(0, |hit| hit.beam.index)).collect();
    for hit in loose {
        let after = firsts.partition_point(|first| *first < hit.beam.index);
        let near = |k: &usize| {
            let (first, last) = (walls[*k].first(), walls[*k].last());
            let beyond = distance(Some(hit), first).min(distance(Some(hit), last));
            beyond <= 0.5 * distance(first, last)
        };
        let candidates = (after.saturating_sub(1)..(after + 1).min(walls.len())).filter(near);
        let nearest = candidates
            .filter_map(|k| Some((k, deviation_squared(hit, lines[k].as_ref()?))))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((k, square)) = nearest
            && square <= settings.gate_sigmas.powi(2)
        {
            let place = walls[k].partition_point(|other| other.beam.index < hit.beam.index);
            walls[k].insert(place, *hit);
        }
    }
}

/// Gives the beams about a corner to the wall on whose side of it they are. The split took the
/// point that noise put farthest out; the crossing of both lines, which hundreds of beams
/// determine, is free of that choice.
fn settle_corners(walls: &mut [Vec<Hit>]) {
    for k in 1..walls.len() {
        let (before, after) = walls.split_at_mut(k);
        let (Some(left), Some(right)) = (before.last_mut(), after.first_mut()) else { continue };
        let Some(corner) = corner(left, right) else { continue };
        let bearing = corner.y.atan2(corner.x);
        let beyond = |hit: &Hit| angle::difference(hit.beam.angle, bearing);
        let (Some(first), Some(last)) = (left.first(), right.last()) else { continue };
        let sweep = beyond(last) - beyond(first);
        let is_left = |hit: &Hit| beyond(hit) * sweep < 0.0;
        let all = [left.as_slice(), right.as_slice()].concat();
        (*left, *right) = all.iter().partition(|hit| is_left(hit));
    }
}

/// Where two neighbouring walls meet; `None` where they do not within noise and spacing.
fn corner(left: &[Hit], right: &[Hit]) -> Option<Point2<f64>> {
    let (a, b) = (fit(left)?, fit(right)?);
    let corner = a.crossing(&b)?;
    let meets = |end: &Hit, inner: &Hit| {
        let spacing = nalgebra::distance(&end.point, &inner.point);
        let allowed = 3.0 * spacing + 6.0 * end.range_variance.sqrt();
        nalgebra::distance(&end.point, &corner) <= allowed
    };
    let ([.., before, last], [first, second, ..]) = (left, right) else { return None };
    (meets(last, before) && meets(first, second)).then_some(corner)
}
