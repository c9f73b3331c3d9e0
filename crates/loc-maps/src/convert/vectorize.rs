//! A grid's walls as lines.
//!
//! The cells that a sensor can hit become points. Where the points around one of them lie along a
//! line, that line is grown: it gathers the points in its way, is fitted to them (least squares of
//! the distances), reaches farther, and ends where the points do.

use super::grow::{Growth, grow};
use super::points::{Surface, surface_cells};
use crate::grid::OccupancyGrid;
use crate::{LineMap, LineSegment, PointMap, Result};
use loc_core::error::{positive, probability};
use nalgebra::{Matrix2, Point2, Vector2};

/// What counts as a line of a grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VectorizeSettings {
    /// Shortest line \[m\].
    pub min_length: f64,
    /// Longest gap inside a line \[m\].
    pub max_gap: f64,
    /// Farthest that a cell may lie off its line \[cells\].
    pub tolerance: f64,
    /// Least share of a line's length that must be covered by cells, in (0, 1].
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

/// The line through points with the least sum of squared distances: the middle, the direction,
/// and the variance across it divided by that along it.
pub(super) fn fit(points: &[Point2<f64>]) -> (Point2<f64>, Vector2<f64>, f64) {
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
