//! A grid's walls as lines, fitted or exact to the cell.
//!
//! The cells that a sensor can hit become points. Where the points around one of them lie along a
//! line, that line is grown: the points near it are gathered, it is fitted to them (least squares
//! of the distances) and extended, and it ends where the points do.

use super::{Surface, surface_cells};
use crate::grid::{Cell, Occupancy, OccupancyGrid};
use crate::{Bounds, LineMap, LineSegment, PointMap, Result};
use loc_core::error::{positive, probability};
use nalgebra::{Matrix2, Point2, Vector2};

/// Criteria for a line of a grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VectorizeSettings {
    /// Shortest line \[m\].
    pub min_length: f64,
    /// Longest gap inside a line \[m\].
    pub max_gap: f64,
    /// Farthest that a cell may lie off its line \[cells\].
    pub tolerance: f64,
    /// Minimum share of a line's length that must be covered by cells, in (0, 1].
    pub min_cover: f64,
}

impl Default for VectorizeSettings {
    /// At least 0.4 m long, with gaps up to 0.15 m, cells up to 1.2 cells off, 70 % covered.
    fn default() -> Self {
        VectorizeSettings { min_length: 0.4, max_gap: 0.15, tolerance: 1.2, min_cover: 0.7 }
    }
}

impl VectorizeSettings {
    fn checked(&self) -> Result<()> {
        positive("shortest line [m]", self.min_length)?;
        positive("longest gap in a line [m]", self.max_gap)?;
        positive("tolerance of a line [cells]", self.tolerance)?;
        positive("cover of a line", self.min_cover)?;
        probability("cover of a line", self.min_cover)?;
        Ok(())
    }
}

impl LineMap {
    /// The walls of a grid as lines, longest first.
    ///
    /// A thick wall gives a line for each of its faces. The lines run through the middle of the
    /// cells that sensors hit.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for settings that are not positive.
    pub fn from_grid(grid: &OccupancyGrid, settings: &VectorizeSettings) -> Result<Self> {
        settings.checked()?;
        let centers = surface_cells(grid, Surface::Boundary).map(|cell| grid.frame().center(cell));
        let points = PointMap::new(centers)?;
        let growth = Growth::new(grid.resolution(), settings);
        let mut used = vec![false; points.len()];
        let mut lines: Vec<LineSegment> = Vec::new();
        for (seed, direction) in seeds(&points, &growth) {
            if !used[seed] {
                lines.extend(grow(&points, &growth, seed, direction, &mut used));
            }
        }
        lines.sort_by(|a, b| b.length().total_cmp(&a.length()));
        LineMap::new(lines)
    }

    /// The borders between occupied and free cells as lines, longest first.
    ///
    /// This is the drawing of a world that is made of cells: a ray through the grid ends on it.
    /// Where cells only sample walls, as in a map that a robot has built,
    /// [`from_grid`](LineMap::from_grid) is nearer to them.
    ///
    /// # Errors
    /// As [`LineMap::new`], for grids more than 1000 km from the origin.
    pub fn outline(grid: &OccupancyGrid) -> Result<Self> {
        let frame = *grid.frame();
        let (width, height) = (frame.width(), frame.height());
        let mut lines = Vec::new();
        for v in 1..height {
            let sides = |u: usize| (Cell::new(u, v - 1), Cell::new(u, v));
            let line = |from: usize, to: usize| LineSegment {
                start: frame.to_map(from as f64, v as f64),
                end: frame.to_map(to as f64, v as f64),
            };
            lines.extend(runs(grid, width, sides).into_iter().map(|[from, to]| line(from, to)));
        }
        for u in 1..width {
            let sides = |v: usize| (Cell::new(u - 1, v), Cell::new(u, v));
            let line = |from: usize, to: usize| LineSegment {
                start: frame.to_map(u as f64, from as f64),
                end: frame.to_map(u as f64, to as f64),
            };
            lines.extend(runs(grid, height, sides).into_iter().map(|[from, to]| line(from, to)));
        }
        lines.sort_by(|a, b| b.length().total_cmp(&a.length()));
        LineMap::new(lines)
    }
}

/// The points about which others lie along a line, straightest first, with its direction.
fn seeds(points: &PointMap, growth: &Growth) -> Vec<(usize, Vector2<f64>)> {
    let mut seeds: Vec<(usize, Vector2<f64>, f64)> = Vec::new();
    for (index, point) in points.points().iter().enumerate() {
        let around = points.within(point, growth.around).into_iter();
        let near: Vec<Point2<f64>> = around.map(|k| points.points()[k]).collect();
        if near.len() < growth.few {
            continue;
        }
        let (_, direction, thickness) = fit(&near);
        seeds.push((index, direction, thickness));
    }
    seeds.sort_by(|a, b| a.2.total_cmp(&b.2).then(a.0.cmp(&b.0)));
    seeds.into_iter().map(|(index, direction, _)| (index, direction)).collect()
}

/// The line through points with the smallest sum of squared distances: the middle, the direction,
/// and the variance across it divided by that along it.
fn fit(points: &[Point2<f64>]) -> (Point2<f64>, Vector2<f64>, f64) {
    let count = points.len().max(1) as f64;
    let middle = points.iter().map(|point| point.coords).sum::<Vector2<f64>>() / count;
    let mut scatter = Matrix2::zeros();
    for point in points {
        let off = point.coords - middle;
        scatter += off * off.transpose();
    }
    let direction = 0.5 * (2.0 * scatter.m12).atan2(scatter.m11 - scatter.m22);
    let along = Vector2::new(direction.cos(), direction.sin());
    let long = (scatter * along).dot(&along);
    let thick = (scatter.trace() - long).max(0.0);
    (Point2::from(middle), along, if long > 0.0 { thick / long } else { 1.0 })
}

/// Maximum number of fits of a line.
const FITS: usize = 20;

/// The settings, in metres and numbers of points.
#[derive(Debug)]
struct Growth {
    /// Radius of the points that give a seed its first direction.
    around: f64,
    /// Minimum number of points there.
    few: usize,
    resolution: f64,
    tolerance: f64,
    max_gap: f64,
    min_length: f64,
    min_cover: f64,
}

/// A line without ends: a point of it and its unit direction.
type Axis = (Point2<f64>, Vector2<f64>);

impl Growth {
    fn new(resolution: f64, settings: &VectorizeSettings) -> Growth {
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
fn grow(
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

/// Where along a grid line the cells on both sides make a wall, each run with one side free.
fn runs(
    grid: &OccupancyGrid,
    count: usize,
    sides: impl Fn(usize) -> (Cell, Cell),
) -> Vec<[usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    let mut before = None;
    for k in 0..count {
        let (one, other) = sides(k);
        let wall = match (grid.occupancy(one), grid.occupancy(other)) {
            (Occupancy::Occupied, Occupancy::Free) => Some(true),
            (Occupancy::Free, Occupancy::Occupied) => Some(false),
            _ => None,
        };
        match runs.last_mut() {
            Some(run) if wall.is_some() && wall == before => run[1] = k + 1,
            _ if wall.is_some() => runs.push([k, k + 1]),
            _ => {}
        }
        before = wall;
    }
    runs
}
