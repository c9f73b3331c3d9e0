//! One line grown from a point through the points in its way.

use super::VectorizeSettings;
use super::vectorize::fit;
use crate::{Bounds, LineSegment, PointMap};
use nalgebra::{Point2, Vector2};

/// Fits of a line, at most.
const FITS: usize = 20;

/// The settings, in metres and numbers of points.
#[derive(Debug)]
pub(super) struct Growth {
    /// Radius in which a point looks for its first direction.
    pub(super) around: f64,
    /// Fewest points there that say something.
    pub(super) few: usize,
    resolution: f64,
    tolerance: f64,
    max_gap: f64,
    min_length: f64,
    min_cover: f64,
}

/// A line without ends: a point of it and its unit direction.
type Axis = (Point2<f64>, Vector2<f64>);

impl Growth {
    pub(super) fn new(resolution: f64, settings: &VectorizeSettings) -> Growth {
        Growth {
            around: 5.0 * resolution,
            few: 5,
            resolution,
            tolerance: settings.tolerance * resolution,
            // Neighbouring cells are up to a diagonal apart, which is no gap.
            max_gap: settings.max_gap + 1.5 * resolution,
            min_length: settings.min_length,
            min_cover: settings.min_cover,
        }
    }

    /// Whether the places along a line (sorted) make a wall: long enough, and covered.
    fn accepts(&self, along: &[f64]) -> bool {
        let (Some(first), Some(last)) = (along.first(), along.last()) else { return false };
        let length = last - first;
        let mut covered: Vec<i64> =
            along.iter().map(|far| ((far - first) / self.resolution) as i64).collect();
        covered.dedup();
        let cover = covered.len() as f64 * self.resolution / length.max(self.resolution);
        length >= self.min_length && cover >= self.min_cover
    }
}

/// Grows a line from a point; marks the points it takes, or the seed where there is no line.
pub(super) fn grow(
    points: &PointMap,
    growth: &Growth,
    seed: usize,
    direction: Vector2<f64>,
    used: &mut [bool],
) -> Option<LineSegment> {
    let start = points.points()[seed];
    let mut axis = (start, direction);
    let mut reach = 2.0 * growth.around;
    let mut members = Vec::new();
    for _ in 0..FITS {
        let before = members.len();
        members = gather(points, growth, &axis, &start, reach);
        let near: Vec<Point2<f64>> = members.iter().map(|&(k, _)| points.points()[k]).collect();
        if near.len() < growth.few {
            break;
        }
        let (middle, along, _) = fit(&near);
        axis = (middle, along);
        // Twice as far each time, until nothing more is found.
        if members.len() == before && reach > 1e6 {
            break;
        }
        reach = if members.len() == before { f64::INFINITY } else { 2.0 * reach };
    }
    used[seed] = true;
    let along: Vec<f64> = members.iter().map(|member| member.1).collect();
    // Lines share the cells of their corners, but two do not share a wall.
    let fresh = members.iter().filter(|member| !used[member.0]).count();
    if 2 * fresh < members.len() || !growth.accepts(&along) {
        return None;
    }
    let line = between(points, &axis, &members)?;
    take(points, growth, &line, used);
    Some(line)
}

/// The points beside an axis that are joined to the start without a long gap, with their
/// places along it, at most `reach` away.
fn gather(
    points: &PointMap,
    growth: &Growth,
    axis: &Axis,
    start: &Point2<f64>,
    reach: f64,
) -> Vec<(usize, f64)> {
    let (middle, along) = axis;
    let origin = (start - middle).dot(along);
    let mut beside = Vec::new();
    points.tree().visit(
        |bounds| near_axis(bounds, axis, growth.tolerance),
        |index, point| {
            let to = point - middle;
            let far = to.dot(along) - origin;
            if to.perp(along).abs() <= growth.tolerance && far.abs() <= reach {
                beside.push((index, far));
            }
        },
    );
    beside.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    let here = beside.partition_point(|member| member.1 < 0.0);
    let is_gap = |pair: &[(usize, f64)]| pair[1].1 - pair[0].1 > growth.max_gap;
    let last = beside.windows(2).skip(here.saturating_sub(1)).position(is_gap);
    let last = last.map_or(beside.len(), |k| k + here.saturating_sub(1) + 1);
    let first = beside[..here].windows(2).rposition(is_gap).map_or(0, |k| k + 1);
    beside[first..last].to_vec()
}

fn near_axis(bounds: &Bounds, (middle, along): &Axis, tolerance: f64) -> bool {
    let off = (bounds.center() - middle).perp(along).abs();
    let half = 0.5 * (bounds.width() * along.y.abs() + bounds.height() * along.x.abs());
    off <= half + tolerance + 1e-9
}

/// The line on the axis from the first member to the last.
fn between(points: &PointMap, axis: &Axis, members: &[(usize, f64)]) -> Option<LineSegment> {
    let (middle, along) = axis;
    let place = |member: &(usize, f64)| (points.points()[member.0] - middle).dot(along);
    let places = members.iter().map(place);
    let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), place| {
        (low.min(place), high.max(place))
    });
    let line = LineSegment { start: middle + along * low, end: middle + along * high };
    line.has_length().then_some(line)
}

/// Marks everything beside a line, a little farther than it gathered, so that the fringe of a
/// thick wall does not become a second one.
fn take(points: &PointMap, growth: &Growth, line: &LineSegment, used: &mut [bool]) {
    let margin = growth.tolerance + growth.resolution;
    let middle = line.at(0.5);
    let radius = 0.5 * line.length() + margin;
    points.visit_within(&middle, radius, |index| {
        if line.distance(&points.points()[index]) <= margin {
            used[index] = true;
        }
    });
}
