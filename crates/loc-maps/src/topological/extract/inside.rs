//! Measurements of one region: centre, width, kind, outline, and the paths to its doors.

use super::regions::{NONE, Passage};
use super::{ExtractSettings, Floor, PlaceKind, around};
use crate::LineSegment;
use crate::grid::Cell;
use nalgebra::Point2;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

/// Steps from cell to cell and across a corner, in units whose ratio is the root of 2.
const STEPS: [u32; 2] = [70, 99];

/// Cost of a cell far from all walls, and the additional cost of cells beside a wall.
const BASE_COST: u32 = 10;
const WALL_COST: u32 = 100;

/// Minimum clearance of a centre, as a share of the largest clearance of its region.
const MIN_CENTER_CLEARANCE: f64 = 0.8;

/// A region, measured.
pub(super) struct Inside {
    /// A cell with large clearance near its centre.
    pub(super) center: Cell,
    /// The paths from there to its passages, by their numbers: points between both \[m\].
    pub(super) paths: HashMap<usize, Vec<Point2<f64>>>,
    pub(super) outline: Vec<Point2<f64>>,
    clearance: u32,
    /// Its length divided by its mean width.
    elongation: f64,
}

impl Inside {
    /// Diameter of the largest circle in it \[m\].
    pub(super) fn width(&self, floor: &Floor) -> f64 {
        (2.0 * floor.metres(self.clearance) - floor.frame.resolution()).max(0.0)
    }

    pub(super) fn kind(&self, settings: &ExtractSettings) -> PlaceKind {
        let leads_on = self.paths.len() >= 2;
        let long = self.elongation >= settings.elongation;
        if leads_on && long { PlaceKind::Corridor } else { PlaceKind::Room }
    }
}

/// Measures all regions.
pub(super) fn measure(floor: &Floor, labels: &[usize], passages: &[Passage]) -> Vec<Inside> {
    let mut cells: Vec<Vec<usize>> = Vec::new();
    for (index, &label) in labels.iter().enumerate().filter(|(_, label)| **label != NONE) {
        if label >= cells.len() {
            cells.resize(label + 1, Vec::new());
        }
        cells[label].push(index);
    }
    let mut far = vec![u32::MAX; labels.len()];
    let regions = cells.iter().enumerate();
    regions
        .map(|(region, cells)| inside(floor, labels, passages, region, cells, &mut far))
        .collect()
}

fn inside(
    floor: &Floor,
    labels: &[usize],
    passages: &[Passage],
    region: usize,
    cells: &[usize],
    far: &mut [u32],
) -> Inside {
    let width = floor.frame.width();
    let clearance = cells.iter().map(|&index| floor.clearance[index]).max().unwrap_or(0);
    let center = center(floor, cells, clearance);
    // First with costs near walls, for paths along the middle of the floor; then from the farthest
    // cell without them, for the length.
    let farthest = |far: &[u32]| cells.iter().copied().max_by_key(|&index| (far[index], index));
    walk_costs(floor, labels, region, center, WALL_COST, far);
    let own = passages.iter().enumerate().filter(|(_, p)| p.between.contains(&region));
    let paths =
        own.map(|(number, p)| (number, path_to(floor, labels, region, p.cell, far))).collect();
    let end = farthest(far).unwrap_or(center);
    cells.iter().for_each(|&index| far[index] = u32::MAX);
    walk_costs(floor, labels, region, end, 0, far);
    let length = farthest(far).map_or(0.0, |index| f64::from(far[index]));
    let length = length / f64::from(STEPS[0] * BASE_COST);
    Inside {
        center: Cell::new(center % width, center / width),
        paths,
        outline: trace(floor, labels, region, cells),
        clearance,
        elongation: length * length / cells.len().max(1) as f64,
    }
}

/// The path from the centre of a region to the cell of a passage, traced back along decreasing
/// costs and then reversed: the points between both.
fn path_to(
    floor: &Floor,
    labels: &[usize],
    region: usize,
    passage: Cell,
    far: &[u32],
) -> Vec<Point2<f64>> {
    let (width, height) = (floor.frame.width(), floor.frame.height());
    let place = |index: usize| Point2::new((index % width) as f64, (index / width) as f64);
    let mut at = passage.row * width + passage.column;
    let mut steps = if labels[at] == region { far[at] } else { u32::MAX };
    let mut cells = vec![place(at)];
    loop {
        let near = around(at, width, height).filter(|&other| labels[other] == region);
        let Some(next) = near.min_by_key(|&other| far[other]).filter(|&k| far[k] < steps) else {
            break;
        };
        (at, steps) = (next, far[next]);
        cells.push(place(at));
    }
    let mut path = straightened(&cells);
    path.reverse();
    let between = path.len().saturating_sub(1).max(1);
    let centers = path.get(1..between).unwrap_or_default().iter();
    centers.map(|p| floor.frame.to_map(p.x + 0.5, p.y + 0.5)).collect()
}

/// The cell nearest to the mean of all cells, of those where a robot can stand, roomy ones first.
fn center(floor: &Floor, cells: &[usize], clearance: u32) -> usize {
    let place = |index: usize| {
        let width = floor.frame.width();
        Point2::new((index % width) as f64, (index / width) as f64)
    };
    let sum: nalgebra::Vector2<f64> = cells.iter().map(|&index| place(index).coords).sum();
    let mean = Point2::from(sum / cells.len().max(1) as f64);
    let roomy = f64::from(clearance) * MIN_CENTER_CLEARANCE * MIN_CENTER_CLEARANCE;
    let rank = |index: usize| {
        let stands = floor.furnished[index] > floor.robot;
        (!stands, f64::from(floor.clearance[index]) < roomy)
    };
    let off = |index: usize| nalgebra::distance_squared(&place(index), &mean);
    let order = |&&a: &&usize, &&b: &&usize| rank(a).cmp(&rank(b)).then(off(a).total_cmp(&off(b)));
    cells.iter().min_by(order).copied().unwrap_or(0)
}

/// The costs of the paths from one cell to all others of its region (Dijkstra): [`STEPS`] times
/// [`BASE_COST`], and more near walls.
fn walk_costs(
    floor: &Floor,
    labels: &[usize],
    region: usize,
    start: usize,
    walls: u32,
    far: &mut [u32],
) {
    let (width, height) = (floor.frame.width(), floor.frame.height());
    let mut open = BinaryHeap::from([Reverse((0, start))]);
    far[start] = 0;
    while let Some(Reverse((steps, index))) = open.pop() {
        if steps > far[index] {
            continue;
        }
        for other in around(index, width, height).filter(|&other| labels[other] == region) {
            let across = other % width != index % width && other / width != index / width;
            let cost = BASE_COST + wall_cost(walls, floor.furnished[other]);
            let steps = steps.saturating_add(STEPS[usize::from(across)] * cost);
            if steps < far[other] {
                far[other] = steps;
                open.push(Reverse((steps, other)));
            }
        }
    }
}

/// Additional cost of a cell: `walls` divided by its clearance, and ten times `walls` under
/// furniture.
fn wall_cost(walls: u32, squared_clearance: u32) -> u32 {
    walls.checked_div(squared_clearance.isqrt()).unwrap_or(10 * walls)
}

/// Corners that lie off the polygon by less than this are left out \[cells\].
const TOLERANCE: f64 = 1.5;
/// Largest change of the area by that, as a share.
const AREA: f64 = 0.2;

/// A corner of cells, in cells from the grid's lower-left one.
type Corner = (isize, isize);

/// East, north, west, south.
const DIRECTIONS: [Corner; 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

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
    let corners = follow_border(start, inside);
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

/// Follows the border with the region on the left, from the lower-left corner of its first
/// cell eastwards, back to there.
fn follow_border(start: Corner, inside: impl Fn(Corner) -> bool) -> Vec<Corner> {
    let (mut at, mut heading) = (start, 0);
    let mut corners = Vec::new();
    loop {
        corners.push(at);
        let (dx, dy) = DIRECTIONS[heading];
        at = (at.0 + dx, at.1 + dy);
        // The cells ahead, right and left of the direction.
        let cell = |(dx, dy): Corner, (lx, ly): Corner, side: isize| {
            let twice = (dx + side * lx - 1, dy + side * ly - 1);
            (at.0 + twice.0.div_euclid(2), at.1 + twice.1.div_euclid(2))
        };
        let left = DIRECTIONS[(heading + 1) % 4];
        heading = if inside(cell((dx, dy), left, -1)) {
            (heading + 3) % 4
        } else if inside(cell((dx, dy), left, 1)) {
            heading
        } else {
            (heading + 1) % 4
        };
        if at == start && heading == 0 {
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

/// The polyline from the first point to the last with fewer corners, both ends kept (Douglas and
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
