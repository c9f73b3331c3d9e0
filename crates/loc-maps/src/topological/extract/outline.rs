//! The outline of a region as a polygon.

use super::floor::Floor;
use crate::LineSegment;
use nalgebra::Point2;

/// Corners that lie off the polygon by less than this are left out \[cells\].
const TOLERANCE: f64 = 1.5;
/// Largest change of the area by that, as a share.
const AREA: f64 = 0.2;

/// A corner of cells, in cells from the grid's lower-left one.
type Corner = (isize, isize);

/// East, north, west, south.
const WAYS: [Corner; 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

/// The outer outline of a region in the map \[m\], counter-clockwise.
pub(super) fn trace(
    floor: &Floor,
    labels: &[usize],
    region: usize,
    cells: &[usize],
) -> Vec<Point2<f64>> {
    let Some(&first) = cells.first() else { return Vec::new() };
    let (width, height) = (floor.frame.width(), floor.frame.height());
    let inside = |(x, y): Corner| match (usize::try_from(x), usize::try_from(y)) {
        (Ok(x), Ok(y)) if x < width && y < height => labels[y * width + x] == region,
        _ => false,
    };
    let start = ((first % width) as isize, (first / width) as isize);
    let corners = walk(start, inside);
    let points: Vec<Point2<f64>> =
        corners.iter().map(|&(x, y)| Point2::new(x as f64, y as f64)).collect();
    let simple = simplified(&points);
    // Of a place hardly wider than the tolerance, nothing would be left.
    let alike = (area(&simple) / area(&points) - 1.0).abs() < AREA;
    let outline = if alike { simple } else { points };
    outline.into_iter().map(|p| floor.frame.to_map(p.x, p.y)).collect()
}

/// Signed area of a polygon, positive where it runs counter-clockwise.
fn area(points: &[Point2<f64>]) -> f64 {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(a, b)| 0.5 * a.coords.perp(&b.coords)).sum()
}

/// Walks along the border with the region on the left, from the lower-left corner of its first
/// cell eastwards, back to there.
fn walk(start: Corner, inside: impl Fn(Corner) -> bool) -> Vec<Corner> {
    let (mut at, mut way) = (start, 0);
    let mut corners = Vec::new();
    loop {
        corners.push(at);
        let (dx, dy) = WAYS[way];
        at = (at.0 + dx, at.1 + dy);
        // The cells ahead, right and left of the way.
        let cell = |(dx, dy): Corner, (lx, ly): Corner, side: isize| {
            let twice = (dx + side * lx - 1, dy + side * ly - 1);
            (at.0 + twice.0.div_euclid(2), at.1 + twice.1.div_euclid(2))
        };
        let left = WAYS[(way + 1) % 4];
        way = if inside(cell((dx, dy), left, -1)) {
            (way + 3) % 4
        } else if inside(cell((dx, dy), left, 1)) {
            way
        } else {
            (way + 1) % 4
        };
        if at == start && way == 0 {
            return corners;
        }
    }
}

/// The polygon with fewer corners.
fn simplified(points: &[Point2<f64>]) -> Vec<Point2<f64>> {
    let Some(first) = points.first() else { return Vec::new() };
    let off = |point: &Point2<f64>| nalgebra::distance_squared(point, first);
    // The closed curve is cut where it starts and where it is farthest from there.
    let farthest = (0..points.len()).max_by(|&a, &b| off(&points[a]).total_cmp(&off(&points[b])));
    let farthest = farthest.unwrap_or(0);
    let mut closed = points.to_vec();
    closed.push(*first);
    let mut kept = straightened(&closed[..=farthest]);
    kept.pop();
    kept.extend(straightened(&closed[farthest..]));
    kept.pop();
    kept
}

/// The way from the first point to the last with fewer corners, both ends kept (Douglas and
/// Peucker 1973).
pub(super) fn straightened(points: &[Point2<f64>]) -> Vec<Point2<f64>> {
    let last = points.len().saturating_sub(1);
    let mut kept = vec![0, last];
    let mut waiting = vec![(0, last)];
    while let Some((from, to)) = waiting.pop() {
        let far = (from + 1..to).map(|k| {
            let chord = LineSegment { start: points[from], end: points[to] };
            (k, chord.distance(&points[k]))
        });
        let Some((corner, far)) = far.max_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
        if far > TOLERANCE {
            kept.push(corner);
            waiting.extend([(from, corner), (corner, to)]);
        }
    }
    kept.sort_unstable();
    kept.dedup();
    kept.into_iter().filter_map(|k| points.get(k)).copied().collect()
}
