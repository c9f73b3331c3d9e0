//! The line map (C2): a vector drawing of the walls.
//!
//! A building drawn as straight lines takes little memory, has no resolution, and is what lines
//! found in a laser scan are matched against. The map answers which line is nearest, where a ray
//! ends, and which parts of which lines can be seen from a place; a search tree (of boxes, halved
//! again and again) keeps these quick. The file format is CSV with the columns `x1,y1,x2,y2` \[m\].
//!
//! ```
//! use loc_core::Pose2;
//! use loc_maps::LineMap;
//! let map = LineMap::parse_csv("room.csv", "x1,y1,x2,y2\n4,-2,4,2\n5,-9,5,9\n")?;
//! let hit = map.ray(&[0.0, 0.0].into(), 0.0, 30.0).unwrap();
//! assert_eq!((hit.line, hit.distance), (0, 4.0));
//!
//! let seen = map.visible_lines(Pose2::IDENTITY, 90_f64.to_radians(), 30.0)?;
//! // The far wall is half hidden by the near one.
//! assert!((seen[0].share() - 1.0).abs() < 1e-6 && seen[1].parts.len() == 2);
//! assert!((seen[1].normal_form.r - 5.0).abs() < 1e-12);
//! # Ok::<(), loc_maps::Error>(())
//! ```

mod csv;
mod segment;
mod visible;

pub use segment::{LineSegment, NormalForm};
pub use visible::VisibleLine;

use crate::tree::{BoxTree, Ray};
use crate::{Bounds, Error, Result};
use loc_sensors::world::RangeWorld;
use nalgebra::Point2;

/// Walls as straight lines, in the order in which they were given.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "Vec<LineSegment>", into = "Vec<LineSegment>"))]
pub struct LineMap {
    lines: Vec<LineSegment>,
    tree: BoxTree<LineSegment>,
}

/// Where a ray meets a [`LineMap`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineHit {
    /// Index of the line.
    pub line: usize,
    /// Distance along the ray \[m\].
    pub distance: f64,
    /// The point that was hit \[m\].
    pub point: Point2<f64>,
}

/// The line of a [`LineMap`] nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearestLine {
    /// Index of the line.
    pub line: usize,
    /// Distance to it \[m\].
    pub distance: f64,
    /// Its nearest point \[m\].
    pub point: Point2<f64>,
}

impl LineMap {
    /// A map of lines; without any, it is an empty plane.
    ///
    /// # Errors
    /// [`Error::LineWithoutLength`], and [`loc_core::Error::OutOfRange`] for ends that are not
    /// finite or farther than 1000 km from the origin.
    pub fn new(lines: impl IntoIterator<Item = LineSegment>) -> Result<Self> {
        let lines: Vec<_> = lines.into_iter().map(LineSegment::checked).collect::<Result<_>>()?;
        Ok(LineMap { tree: BoxTree::new(lines.iter().copied()), lines })
    }

    /// The lines, in the order in which they were given.
    pub fn lines(&self) -> &[LineSegment] {
        &self.lines
    }

    /// Number of lines.
    pub fn len(&self) -> usize {
        self.lines.len()
    }

    /// Whether there are no lines.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    /// The smallest box around all lines; `None` where there are none.
    pub fn bounds(&self) -> Option<Bounds> {
        self.tree.bounds()
    }

    /// The line nearest to a point \[m\]; `None` in an empty map and for points that are not
    /// finite.
    pub fn nearest(&self, point: &Point2<f64>) -> Option<NearestLine> {
        let squared = |line: &LineSegment| {
            nalgebra::distance_squared(point, &line.at(line.nearest_fraction(point)))
        };
        let (line, squared) = self.tree.nearest(point, f64::INFINITY, squared)?;
        let nearest = self.lines[line].at(self.lines[line].nearest_fraction(point));
        Some(NearestLine { line, distance: squared.sqrt(), point: nearest })
    }

    /// The first line on the ray from `origin` \[m\] in `direction` \[rad\], at most `max_range`
    /// \[m\] away, exactly: see [`LineSegment::cast`] for starts on lines and rays along them.
    pub fn ray(&self, origin: &Point2<f64>, direction: f64, max_range: f64) -> Option<LineHit> {
        let ray = Ray::new(origin, direction);
        let (line, distance) = self.tree.cast(&ray, max_range, 0.0, |line| line.hit(&ray))?;
        Some(LineHit { line, distance, point: ray.origin + ray.along * distance })
    }
}

impl RangeWorld for LineMap {
    fn cast(&self, origin: &Point2<f64>, direction: f64, max_range: f64) -> Option<f64> {
        let ray = Ray::new(origin, direction);
        self.tree.cast(&ray, max_range, 0.0, |line| line.hit(&ray)).map(|(_, distance)| distance)
    }
}

impl PartialEq for LineMap {
    fn eq(&self, other: &LineMap) -> bool {
        self.lines == other.lines
    }
}

impl TryFrom<Vec<LineSegment>> for LineMap {
    type Error = Error;
    fn try_from(lines: Vec<LineSegment>) -> Result<Self> {
        LineMap::new(lines)
    }
}

impl From<LineMap> for Vec<LineSegment> {
    fn from(map: LineMap) -> Self {
        map.lines
    }
}
