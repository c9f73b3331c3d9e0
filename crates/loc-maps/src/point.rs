//! The point map (C3): a set of obstacle points.
//!
//! The end points of laser scans in one frame make a map without extracted walls. Queries: the
//! nearest point (for scan matching), the points around a position, and where a ray ends, at the
//! first point within half a beam's width of it.
//! A search tree of boxes, shared with the line map, makes these fast. The file format is CSV
//! with the columns `x,y` \[m\].
//!
//! ```
//! use loc_core::Pose2;
//! use loc_maps::PointMap;
//! // The same corner, seen by two scans from two positions.
//! let first = [[2.0, 0.0].into(), [2.0, 0.5].into()];
//! let second = [[1.0, 0.01].into()];
//! let scans = [(Pose2::IDENTITY, &first[..]), (Pose2::new(1.0, 0.0, 0.0), &second[..])];
//! let map = PointMap::from_scans(scans, 0.1)?.with_half_width(0.05)?;
//! assert_eq!(map.len(), 2);
//!
//! let nearest = map.nearest(&[2.1, 0.6].into()).unwrap();
//! assert_eq!(map.points()[nearest.point], [2.0, 0.5].into());
//! # Ok::<(), loc_maps::Error>(())
//! ```

use crate::bounds::{column, coordinate};
use crate::tree::{BoxTree, Ray};
use crate::{Bounds, Error, Result};
use loc_core::Pose2;
use loc_core::error::positive;
use loc_core::table::Table;
use loc_sensors::world::RangeWorld;
use nalgebra::{Point2, Vector2};
use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Default half width of a beam \[m\].
const HALF_WIDTH: f64 = 0.05;

/// Obstacle points, in the order in which they were given.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "Stored", into = "Stored"))]
pub struct PointMap {
    points: Vec<Point2<f64>>,
    half_width: f64,
    tree: BoxTree<Point2<f64>>,
}

/// The point of a [`PointMap`] nearest to a position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearestPoint {
    /// Index of the point.
    pub point: usize,
    /// Distance to it \[m\].
    pub distance: f64,
}

/// Where a ray meets a [`PointMap`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointHit {
    /// Index of the point.
    pub point: usize,
    /// Distance along the ray to the place where it passes the point \[m\].
    pub distance: f64,
}

impl PointMap {
    /// A map of points \[m\]; without any, it is an empty plane.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for points that are not finite or farther than 1000 km from
    /// the origin.
    pub fn new(points: impl IntoIterator<Item = Point2<f64>>) -> Result<Self> {
        let points: Vec<Point2<f64>> = points.into_iter().collect();
        for value in points.iter().flat_map(|point| [point.x, point.y]) {
            coordinate("point of a map [m]", value)?;
        }
        let tree = BoxTree::new(points.iter().copied());
        Ok(PointMap { points, half_width: HALF_WIDTH, tree })
    }

    /// Sets half the width of the beams that the map stops as a [`RangeWorld`] \[m\], 0.05 else.
    ///
    /// Above half the distance between neighbouring points of a wall, no beam slips through it.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] where it is not positive.
    pub fn with_half_width(mut self, half_width: f64) -> Result<Self> {
        self.half_width = positive("half width of a beam [m]", half_width)?;
        Ok(self)
    }

    /// Half the width of the beams that the map stops as a [`RangeWorld`] \[m\].
    pub fn half_width(&self) -> f64 {
        self.half_width
    }

    /// The points, in the order in which they were given.
    pub fn points(&self) -> &[Point2<f64>] {
        &self.points
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// The smallest box around all points; `None` where there are none.
    pub fn bounds(&self) -> Option<Bounds> {
        self.tree.bounds()
    }

    pub(crate) fn tree(&self) -> &BoxTree<Point2<f64>> {
        &self.tree
    }

    /// The point nearest to a position \[m\]; `None` in an empty map and for places that are not
    /// finite.
    pub fn nearest(&self, place: &Point2<f64>) -> Option<NearestPoint> {
        self.nearest_within(place, f64::INFINITY)
    }

    /// The same, at most `radius` \[m\] away, which is quicker where nothing is near.
    pub fn nearest_within(&self, place: &Point2<f64>, radius: f64) -> Option<NearestPoint> {
        let limit = if radius >= 0.0 { radius * radius } else { f64::NAN };
        let squared = |point: &Point2<f64>| nalgebra::distance_squared(point, place);
        let (point, squared) = self.tree.nearest(place, limit, squared)?;
        Some(NearestPoint { point, distance: squared.sqrt() })
    }

    /// Calls `visit` with the index of every point at most `radius` \[m\] from a position, always
    /// in the same order.
    pub fn visit_within(&self, place: &Point2<f64>, radius: f64, mut visit: impl FnMut(usize)) {
        let squared = if radius >= 0.0 { radius * radius } else { f64::NAN };
        self.tree.visit(
            |bounds| bounds.squared_distance(place) <= squared,
            |index, point| {
                if nalgebra::distance_squared(point, place) <= squared {
                    visit(index);
                }
            },
        );
    }

    /// The indices of the points at most `radius` \[m\] from a position, in order.
    pub fn within(&self, place: &Point2<f64>, radius: f64) -> Vec<usize> {
        let mut found = Vec::new();
        self.visit_within(place, radius, |index| found.push(index));
        found.sort_unstable();
        found
    }

    /// The first point at most `half_width` \[m\] beside the ray from `origin` \[m\] in
    /// `direction` \[rad\], at most `max_range` \[m\] along it.
    pub fn ray(
        &self,
        origin: &Point2<f64>,
        direction: f64,
        max_range: f64,
        half_width: f64,
    ) -> Option<PointHit> {
        let ray = Ray::new(origin, direction);
        let passed = |point: &Point2<f64>| {
            let to = point - ray.origin;
            let far = to.dot(&ray.along);
            (far >= 0.0 && to.perp(&ray.along).abs() <= half_width).then_some(far)
        };
        let (point, distance) = self.tree.cast(&ray, max_range, half_width, passed)?;
        Some(PointHit { point, distance })
    }

    /// The map of scans: poses `map_from_sensor` with points in the sensor's frame \[m\], thinned
    /// to one point per square of side `square` \[m\].
    ///
    /// # Errors
    /// As [`PointMapBuilder::new`] and [`PointMapBuilder::add_scan`].
    pub fn from_scans<'a>(
        scans: impl IntoIterator<Item = (Pose2, &'a [Point2<f64>])>,
        square: f64,
    ) -> Result<Self> {
        let mut builder = PointMapBuilder::new(square)?;
        for (map_from_sensor, points) in scans {
            builder.add_scan(map_from_sensor, points)?;
        }
        builder.build()
    }

    /// The map with one point per square of side `square` \[m\].
    ///
    /// # Errors
    /// As [`PointMapBuilder::new`].
    pub fn thinned(&self, square: f64) -> Result<Self> {
        let whole = [(Pose2::IDENTITY, self.points())];
        PointMap::from_scans(whole, square)?.with_half_width(self.half_width())
    }

    /// Reads a text file with the columns `x,y` \[m\], at commas or white space.
    ///
    /// # Errors
    /// [`loc_core::Error`] for files that cannot be read, with line and column for what cannot be
    /// understood, and for a file without points.
    pub fn read_csv(file: impl AsRef<Path>) -> Result<Self> {
        PointMap::from_table(&Table::read(file, &COLUMNS)?)
    }

    /// The same from a text; `file` is only named in errors.
    ///
    /// # Errors
    /// As [`PointMap::read_csv`].
    pub fn parse_csv(file: impl Into<PathBuf>, text: &str) -> Result<Self> {
        PointMap::from_table(&Table::parse(file, text, &COLUMNS))
    }

    /// The points as the text of a CSV file, every number to its last digit.
    pub fn to_csv(&self) -> String {
        let mut text = COLUMNS.join(",") + "\n";
        for point in self.points() {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{},{}", point.x, point.y);
        }
        text
    }

    fn from_table(table: &Table) -> Result<Self> {
        let mut points = Vec::new();
        for row in table.rows() {
            let row = row?;
            points.push(Point2::new(column(&row, "x")?, column(&row, "y")?));
        }
        if points.is_empty() {
            let file = table.file().to_owned();
            return Err(Error::Core(loc_core::Error::Empty { file, what: "points" }));
        }
        PointMap::new(points)
    }
}

impl RangeWorld for PointMap {
    fn cast(&self, origin: &Point2<f64>, direction: f64, max_range: f64) -> Option<f64> {
        self.ray(origin, direction, max_range, self.half_width).map(|hit| hit.distance)
    }
}

impl PartialEq for PointMap {
    fn eq(&self, other: &PointMap) -> bool {
        self.points == other.points && self.half_width.total_cmp(&other.half_width).is_eq()
    }
}

/// What is stored of a map: the tree is built anew.
#[cfg(feature = "serde")]
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
struct Stored {
    half_width: f64,
    points: Vec<Point2<f64>>,
}

#[cfg(feature = "serde")]
impl TryFrom<Stored> for PointMap {
    type Error = crate::Error;
    fn try_from(stored: Stored) -> Result<Self> {
        PointMap::new(stored.points)?.with_half_width(stored.half_width)
    }
}

#[cfg(feature = "serde")]
impl From<PointMap> for Stored {
    fn from(map: PointMap) -> Self {
        Stored { half_width: map.half_width, points: map.points }
    }
}

/// Squares along one axis, at most on each side: what a float counts without gaps.
const SQUARES: f64 = 9e15;

/// Gathers the points of scans, and thins them while it does.
///
/// The plane is cut into squares; all points of a square become one at their mean. So a wall seen
/// a thousand times takes no more room than one seen once, and its noise averages out.
#[derive(Debug, Clone)]
pub struct PointMapBuilder {
    square: f64,
    index: HashMap<(i64, i64), usize>,
    sums: Vec<(Vector2<f64>, f64)>,
}

impl PointMapBuilder {
    /// A builder that keeps one point per square of the given side \[m\].
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] where that is not positive.
    pub fn new(square: f64) -> Result<Self> {
        positive("side of the squares of a point map [m]", square)?;
        Ok(PointMapBuilder { square, index: HashMap::new(), sums: Vec::new() })
    }

    /// Adds the points of one scan, in the sensor's frame \[m\], taken at the pose
    /// `map_from_sensor`.
    ///
    /// Points that are not finite are beams that hit nothing, and are passed over.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a pose that is not finite, and for points more than
    /// 1000 km away.
    pub fn add_scan(&mut self, map_from_sensor: Pose2, points: &[Point2<f64>]) -> Result<()> {
        for value in [map_from_sensor.x, map_from_sensor.y, map_from_sensor.theta] {
            coordinate("pose of a scan [m, m, rad]", value)?;
        }
        let rotation = map_from_sensor.rotation();
        let translation = map_from_sensor.position().coords;
        for point in points.iter().filter(|point| point.coords.iter().all(|c| c.is_finite())) {
            self.add(rotation * point.coords + translation)?;
        }
        Ok(())
    }

    /// The map of what was added, in the order in which its squares were first met.
    ///
    /// # Errors
    /// As [`PointMap::new`], which cannot happen with points that were accepted.
    pub fn build(self) -> Result<PointMap> {
        PointMap::new(self.sums.into_iter().map(|(sum, count)| Point2::from(sum / count)))
    }

    fn add(&mut self, point: Vector2<f64>) -> Result<()> {
        let number = |value: f64| -> Result<i64> {
            let number = (coordinate("point of a scan [m]", value)? / self.square).floor();
            // Squares are counted exactly unless they are smaller than a nanometre.
            Ok(number.clamp(-SQUARES, SQUARES) as i64)
        };
        let square = (number(point.x)?, number(point.y)?);
        let next = self.sums.len();
        let index = *self.index.entry(square).or_insert(next);
        if index == next {
            self.sums.push((point, 1.0));
        } else {
            self.sums[index].0 += point;
            self.sums[index].1 += 1.0;
        }
        Ok(())
    }
}

const COLUMNS: [&str; 2] = ["x", "y"];
