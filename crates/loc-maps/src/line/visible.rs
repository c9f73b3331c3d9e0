//! Which lines, and which parts of them, are visible from a position.
//!
//! The directions at which lines begin, end, or come into range cut the field of view into
//! sectors. Within a sector no line begins or ends, so the nearest one at any direction comes from
//! a fixed set, and 1 / distance of each is linear in a suitable parameter: a line that is nearest
//! at both borders is nearest throughout. Where two lines are, they hide each other in turn, and
//! the sector is cut where they cross. So the parts are exact, up to [`STEP`].

use super::{LineMap, LineSegment, NormalForm};
use crate::tree::Ray;
use crate::{Result, bounds::coordinate};
use loc_core::error::positive;
use loc_core::{Pose2, angle};
use nalgebra::Point2;
use std::f64::consts::TAU;

/// How far inside a sector its border is evaluated \[rad\]; narrower sectors are passed over.
const STEP: f64 = 1e-9;
/// Parts with smaller gaps than this are one, as fraction of a line.
const GAP: f64 = 1e-6;
/// Parts shorter than this are none, as fraction of a line.
const MIN_PART: f64 = 1e-9;
/// Lines closer behind each other than this count as equally near \[m\].
const SAME: f64 = 1e-10;
/// Cuts of one sector, at most.
const CUTS: usize = 200;

/// A line of a [`LineMap`] as it is seen from a pose.
#[derive(Debug, Clone, PartialEq)]
pub struct VisibleLine {
    /// Index of the line in the map.
    pub line: usize,
    /// The line in the robot's frame, hidden parts included \[m\].
    pub segment: LineSegment,
    /// (r, alpha) of the line in the robot's frame.
    pub normal_form: NormalForm,
    /// The visible parts as fractions \[from, to\] of the length from start to end, in order.
    pub parts: Vec<[f64; 2]>,
}

impl VisibleLine {
    /// The share of the line that is visible, in (0, 1].
    pub fn share(&self) -> f64 {
        self.parts.iter().map(|[from, to]| to - from).sum()
    }

    /// Length of all visible parts \[m\].
    pub fn visible_length(&self) -> f64 {
        self.share() * self.segment.length()
    }
}

impl LineMap {
    /// The lines that a scanner at `pose` sees, in the order of the map.
    ///
    /// `fov` is the whole field of view about the heading \[rad\], from 2 pi on all around;
    /// `max_range` \[m\] may be infinite. Hidden parts, and parts out of range, are cut away
    /// (lecture ID H4). From a position on a line nothing is visible.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a pose that is not finite, and for `fov` and
    /// `max_range` that are not positive.
    pub fn visible_lines(&self, pose: Pose2, fov: f64, max_range: f64) -> Result<Vec<VisibleLine>> {
        for value in [pose.x, pose.y, pose.theta] {
            coordinate("pose to see lines from [m, m, rad]", value)?;
        }
        positive("field of view [rad]", fov)?;
        let max_range = if max_range == f64::INFINITY { f64::MAX } else { max_range };
        let max_range = positive("greatest range [m]", max_range)?;
        let view = View { map: self, origin: pose.position(), max_range, heading: pose.theta };
        let cuts = view.cuts(fov.min(TAU) / 2.0);
        let mut seen = Vec::new();
        for sector in cuts.windows(2) {
            view.sector(sector[0], sector[1], &mut seen);
        }
        seen.sort_by(|a, b| a.0.cmp(&b.0).then(a.1[0].total_cmp(&b.1[0])));
        Ok(view.gather(&seen, pose))
    }
}

/// A line and a visible part of it.
type Part = (usize, [f64; 2]);

struct View<'a> {
    map: &'a LineMap,
    origin: Point2<f64>,
    max_range: f64,
    heading: f64,
}

impl View<'_> {
    /// The directions at which what is seen may change, relative to the heading, in order.
    fn cuts(&self, half_fov: f64) -> Vec<f64> {
        let mut cuts = vec![-half_fov, half_fov];
        let squared = self.max_range * self.max_range;
        let mut cut = |point: Point2<f64>| {
            let to = point - self.origin;
            let direction = angle::wrap(to.y.atan2(to.x) - self.heading);
            if direction.abs() < half_fov {
                cuts.push(direction);
            }
        };
        self.map.tree.visit(
            |bounds| bounds.squared_distance(&self.origin) <= squared,
            |_, line| {
                for end in [line.start, line.end] {
                    if nalgebra::distance_squared(&end, &self.origin) <= squared {
                        cut(end);
                    }
                }
                for fraction in circle_crossings(line, &self.origin, self.max_range) {
                    cut(line.at(fraction));
                }
            },
        );
        cuts.sort_by(f64::total_cmp);
        cuts
    }

    /// Finds what is seen between two directions, between which no line begins or ends.
    fn sector(&self, from: f64, to: f64, seen: &mut Vec<Part>) {
        let mut waiting = vec![(from, to)];
        // Lines that lie on each other, up to rounding, would be cut without end.
        let mut patience = CUTS;
        while let Some((from, to)) = waiting.pop() {
            if to - from <= 4.0 * STEP || patience == 0 {
                continue;
            }
            patience -= 1;
            match (self.line_at(from + STEP), self.line_at(to - STEP)) {
                (Some(a), Some(b)) if a == b || self.hides(a, b, to - STEP) => {
                    self.push(a, from, to, seen);
                }
                (Some(a), Some(b)) if self.hides(b, a, from + STEP) => {
                    self.push(b, from, to, seen);
                }
                (Some(a), Some(b)) => {
                    let middle = self.crossing(a, b, from, to);
                    waiting.extend(cut_at(from, middle.unwrap_or((from + to) / 2.0), to));
                }
                (None, None) => {}
                // An end so close to the border that rounding moved it across.
                _ => waiting.extend(cut_at(from, (from + to) / 2.0, to)),
            }
        }
    }

    /// Whether a line is as near as another in a direction, up to rounding.
    fn hides(&self, line: usize, other: usize, direction: f64) -> bool {
        let ray = Ray::new(&self.origin, self.heading + direction);
        let [near, far] = [line, other].map(|index| self.map.lines[index].hit(&ray));
        matches!((near, far), (Some(near), Some(far)) if near <= far + SAME)
    }

    fn line_at(&self, direction: f64) -> Option<usize> {
        let ray = Ray::new(&self.origin, self.heading + direction);
        let hit = |line: &LineSegment| line.hit(&ray);
        self.map.tree.cast(&ray, self.max_range, 0.0, hit).map(|(line, _)| line)
    }

    /// The direction strictly between two others in which two lines cross.
    fn crossing(&self, a: usize, b: usize, from: f64, to: f64) -> Option<f64> {
        let [a, b] = [a, b].map(|line| self.map.lines[line]);
        let (along, other) = (a.end - a.start, b.end - b.start);
        let fraction = (b.start - a.start).perp(&other) / along.perp(&other);
        let point = a.start + along * fraction - self.origin;
        let middle = (from + to) / 2.0;
        let direction = point.y.atan2(point.x) - self.heading;
        let direction = middle + angle::wrap(direction - middle);
        // NaN (parallel lines) and the borders are excluded.
        (direction > from + STEP && direction < to - STEP).then_some(direction)
    }

    fn push(&self, index: usize, from: f64, to: f64, seen: &mut Vec<Part>) {
        let line = self.map.lines[index];
        let [from, to] = [from, to].map(|direction| self.fraction(&line, direction));
        if from.is_finite() && to.is_finite() && (to - from).abs() > MIN_PART {
            seen.push((index, [from.min(to), from.max(to)]));
        }
    }

    /// Where along a line a ray crosses it, as a fraction.
    fn fraction(&self, line: &LineSegment, direction: f64) -> f64 {
        let ray = Ray::new(&self.origin, self.heading + direction);
        let side = |end: Point2<f64>| (end - ray.origin).perp(&ray.along);
        let (start, end) = (side(line.start), side(line.end));
        (start / (start - end)).clamp(0.0, 1.0)
    }

    /// Joins parts that touch, and gathers those of one line.
    fn gather(&self, seen: &[Part], pose: Pose2) -> Vec<VisibleLine> {
        let mut lines: Vec<VisibleLine> = Vec::new();
        for &(line, part) in seen {
            match lines.last_mut().filter(|last| last.line == line) {
                Some(last) => match last.parts.last_mut() {
                    Some(before) if part[0] - before[1] < GAP => before[1] = part[1],
                    _ => last.parts.push(part),
                },
                None => {
                    let segment = self.map.lines[line].seen_from(pose);
                    let normal_form = segment.normal_form();
                    lines.push(VisibleLine { line, segment, normal_form, parts: vec![part] });
                }
            }
        }
        lines
    }
}

fn cut_at(from: f64, middle: f64, to: f64) -> [(f64, f64); 2] {
    [(from, middle), (middle, to)]
}

/// The fractions at which a line crosses a circle.
fn circle_crossings(
    line: &LineSegment,
    center: &Point2<f64>,
    radius: f64,
) -> impl Iterator<Item = f64> {
    let (along, to) = (line.end - line.start, center - line.start);
    let length = along.norm();
    let middle = to.dot(&along) / length;
    let off = to.perp(&along) / length;
    let half = (radius * radius - off * off).max(0.0).sqrt();
    let crossings = [middle - half, middle + half].map(|far| far / length);
    crossings.into_iter().filter(|fraction| (0.0..=1.0).contains(fraction))
}
