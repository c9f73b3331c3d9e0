//! From a scan to its lines.

use super::Line;
use super::line::{Hit, fit, refined};
use crate::Result;
use crate::laser::{LaserNoise, LaserScan};
use loc_core::angle;
use nalgebra::Point2;
use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

loc_core::settings! {
    /// Finds straight walls in a scan.
    ///
    /// Beams fall into runs at breakpoints; a run is split until each part is straight as far as
    /// noise and roughness can tell; neighbouring parts that are one wall are merged; beams about a
    /// corner are assigned to the wall on their side of it; each wall is fitted.
    ///
    /// For an indoor scanner with errors of 2 cm.
    #[derive(Copy)]
    pub struct LineExtractor {
        /// Errors of the ranges.
        pub noise: LaserNoise = LaserNoise { sigma: 0.02, sigma_per_m: 0.0 } => check;
        /// Standard deviation of a beam's direction \[rad\].
        #[serde(with = "loc_core::settings::angle")]
        pub angle_sigma: f64 = 0.001 => non_negative;
        /// Standard deviation of a wall's surface about its plane \[m\].
        pub roughness: f64 = 0.005 => non_negative;
        /// How many standard deviations a point may lie off its wall.
        pub gate_sigmas: f64 = 5.0 => positive;
        /// The flattest angle between beam and wall at which a wall is followed \[rad\].
        #[serde(with = "loc_core::settings::angle")]
        pub grazing_angle: f64 = 5_f64.to_radians() => holds(
            "between 0 and pi/2",
            |e| e.grazing_angle > 0.0 && e.grazing_angle < FRAC_PI_2
        );
        /// The widest angle without a return that a wall may continue across \[rad\].
        pub max_gap: f64 = 3_f64.to_radians() => positive;
        /// A wall needs this many beams.
        pub min_points: usize = 10 => at_least(3);
        /// A wall must be this long \[m\].
        pub min_length: f64 = 0.3 => non_negative;
        /// Its direction must be known this well \[rad\]: the beams of a short piece beyond a
        /// corner are ambiguous, and its covariance would be overconfident.
        #[serde(with = "loc_core::settings::angle")]
        pub max_alpha_sigma: f64 = 0.03 => positive;
    }
}

impl LineExtractor {
    /// An extractor for a scanner with the given errors.
    pub fn new(noise: LaserNoise) -> Self {
        LineExtractor { noise, ..LineExtractor::default() }
    }

    /// The walls in a scan, in the scanner's frame and in the order of the beams.
    ///
    /// # Errors
    /// Those of [`LaserScan::check`] and [`LineExtractor::check`].
    pub fn extract(&self, scan: &LaserScan) -> Result<Vec<Line>> {
        self.check()?;
        scan.check()?;
        let hits: Vec<Hit> = scan.beams().map(|beam| Hit::new(beam, self)).collect();
        let mut parts = Vec::new();
        for run in runs(&hits, self, scan.angle_increment.abs()) {
            split(&hits, run, self, &mut parts);
        }
        let walls = assemble(&hits, &parts, self);
        let enough = |line: &Line| {
            line.points >= self.min_points
                && line.length() >= self.min_length
                && line.covariance.m22 <= self.max_alpha_sigma.powi(2)
        };
        Ok(walls.iter().filter_map(|wall| refined(wall)).filter(enough).collect())
    }
}

/// Runs of beams without a gap: one ends where the next point is farther away than a wall could
/// put it that the beam meets at the grazing angle (Borges and Aldon 2004).
fn runs(hits: &[Hit], settings: &LineExtractor, step: f64) -> Vec<Range<usize>> {
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
fn split(
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
fn is_straight(part: &[Hit], settings: &LineExtractor) -> bool {
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
fn deviation_squared(hit: &Hit, line: &Line) -> f64 {
    line.distance(&hit.point).powi(2) / hit.variance(line.alpha)
}

/// Index of the point farthest from the straight line between the ends, never an end.
fn farthest_from_chord(part: &[Hit]) -> usize {
    let last = part.len() - 1;
    let (from, to) = (part[0].point, part[last].point);
    let across = |k: usize| (to - from).perp(&(part[k].point - from)).abs();
    (1..last).max_by(|&a, &b| across(a).total_cmp(&across(b))).unwrap_or(1).max(1)
}

/// Makes walls of the straight parts of a scan, each a list of hits in the order of the beams.
fn assemble(hits: &[Hit], parts: &[Range<usize>], settings: &LineExtractor) -> Vec<Vec<Hit>> {
    let (large, small): (Vec<_>, Vec<_>) =
        parts.iter().cloned().partition(|part| part.len() >= settings.min_points);
    let mut walls = merge(hits, &large, settings);
    let mut unassigned: Vec<Hit> = small.into_iter().flat_map(|part| hits[part].to_vec()).collect();
    remove_corner_pieces(&mut walls, &mut unassigned, settings);
    assign_points(&mut walls, &unassigned, settings);
    reassign_corners(&mut walls);
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

/// Removes a wall whose points all lie on one of its two neighbours: an artefact of the split at a
/// corner.
fn remove_corner_pieces(
    walls: &mut Vec<Vec<Hit>>,
    unassigned: &mut Vec<Hit>,
    settings: &LineExtractor,
) {
    let mut k = 1;
    while k + 1 < walls.len() {
        let neighbours = [fit(&walls[k - 1]), fit(&walls[k + 1])];
        let is_on = |hit: &Hit, line| deviation_squared(hit, line) <= settings.gate_sigmas.powi(2);
        let explained = |hit: &Hit| neighbours.iter().flatten().any(|line| is_on(hit, line));
        let shorter = walls[k].len() < walls[k - 1].len().min(walls[k + 1].len());
        if shorter && walls[k].iter().all(explained) {
            unassigned.extend(walls.remove(k));
        } else {
            k += 1;
        }
    }
}

/// Assigns points between two walls to the one they lie on, where they lengthen it by less than
/// half.
fn assign_points(walls: &mut [Vec<Hit>], unassigned: &[Hit], settings: &LineExtractor) {
    let lines: Vec<Option<Line>> = walls.iter().map(|wall| fit(wall)).collect();
    let firsts: Vec<usize> =
        walls.iter().map(|wall| wall.first().map_or(0, |hit| hit.beam.index)).collect();
    for hit in unassigned {
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

/// Assigns the beams about a corner to the wall on their side of it. The split uses the single
/// point that noise put farthest out; the intersection of both lines, which hundreds of beams
/// determine, does not depend on it.
fn reassign_corners(walls: &mut [Vec<Hit>]) {
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
