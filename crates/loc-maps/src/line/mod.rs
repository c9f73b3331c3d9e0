//! The line map (C2): a vector drawing of the walls.
//!
//! Straight lines take little memory, have no resolution, and are what lines extracted from a laser
//! scan are matched with. Queries: the nearest line, where a ray ends, and which parts of which
//! lines are visible from a position; a bounding volume hierarchy makes these fast. The file format
//! is CSV with the columns `x1,y1,x2,y2` \[m\].
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

mod visible;

pub use visible::VisibleLine;

use crate::bounds::{column, coordinate};
use crate::tree::{Bounded, BoxTree, Ray};
use crate::{Bounds, Error, Result};
use loc_core::table::{Row, Table};
use loc_core::{Pose2, angle};
use loc_sensors::world::RangeWorld;
use nalgebra::{Point2, Vector2};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

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

    /// Reads a text file with the columns `x1,y1,x2,y2` \[m\], at commas or white space.
    ///
    /// # Errors
    /// [`loc_core::Error`] for files that cannot be read, with line and column for what cannot be
    /// understood and for a line without length, and for a file without lines.
    pub fn read_csv(file: impl AsRef<Path>) -> Result<Self> {
        LineMap::from_table(&Table::read(file, &COLUMNS)?)
    }

    /// The same from a text; `file` is only named in errors.
    ///
    /// # Errors
    /// As [`LineMap::read_csv`].
    pub fn parse_csv(file: impl Into<PathBuf>, text: &str) -> Result<Self> {
        LineMap::from_table(&Table::parse(file, text, &COLUMNS))
    }

    /// The map as the text of a CSV file, every number to its last digit.
    pub fn to_csv(&self) -> String {
        let mut text = COLUMNS.join(",") + "\n";
        for LineSegment { start, end } in self.lines() {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{},{},{},{}", start.x, start.y, end.x, end.y);
        }
        text
    }

    fn from_table(table: &Table) -> Result<Self> {
        let lines: Vec<LineSegment> =
            table.rows().map(|row| from_row(&row?)).collect::<loc_core::Result<_>>()?;
        if lines.is_empty() {
            let file = table.file().to_owned();
            return Err(Error::Core(loc_core::Error::Empty { file, what: "lines" }));
        }
        LineMap::new(lines)
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

/// Rays that start on a line, up to rounding, hit it \[m\].
const ON_LINE: f64 = 1e-9;

/// A straight wall between two points.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LineSegment {
    /// Where it starts \[m\].
    pub start: Point2<f64>,
    /// Where it ends \[m\].
    pub end: Point2<f64>,
}

/// A line without ends in Hessian normal form: `x cos(alpha) + y sin(alpha) = r`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NormalForm {
    /// Distance of the line from the origin \[m\], at least 0.
    pub r: f64,
    /// Direction from the origin to the nearest point of the line \[rad\], in (-pi, pi].
    pub alpha: f64,
}

impl LineSegment {
    /// The line from one point to another \[m\].
    pub fn new(start: [f64; 2], end: [f64; 2]) -> Self {
        LineSegment { start: start.into(), end: end.into() }
    }

    /// Its length \[m\].
    pub fn length(&self) -> f64 {
        nalgebra::distance(&self.start, &self.end)
    }

    /// The point at a fraction of the length, 0 the start and 1 the end \[m\].
    pub fn at(&self, fraction: f64) -> Point2<f64> {
        self.start + (self.end - self.start) * fraction
    }

    /// Its direction from start to end \[rad\].
    pub fn direction(&self) -> f64 {
        let along = self.end - self.start;
        along.y.atan2(along.x)
    }

    /// The line as seen from a frame at `pose`.
    #[must_use]
    pub fn seen_from(&self, pose: Pose2) -> LineSegment {
        let into_frame = pose.inverse();
        LineSegment {
            start: into_frame.transform(&self.start),
            end: into_frame.transform(&self.end),
        }
    }

    /// The line it lies on, in the frame of its coordinates.
    ///
    /// Where that passes through the origin, alpha is a quarter turn left of its direction.
    pub fn normal_form(&self) -> NormalForm {
        let normal = self.direction() + std::f64::consts::FRAC_PI_2;
        let (sin, cos) = normal.sin_cos();
        // The middle of the ends, for their errors cancel there.
        let middle = self.at(0.5);
        let r = middle.x * cos + middle.y * sin;
        let turned = if r < 0.0 { normal + std::f64::consts::PI } else { normal };
        NormalForm { r: r.abs(), alpha: angle::wrap(turned) }
    }

    /// Fraction of the length at which a point is nearest, in \[0, 1\].
    pub fn nearest_fraction(&self, point: &Point2<f64>) -> f64 {
        let along = self.end - self.start;
        let fraction = (point - self.start).dot(&along) / along.norm_squared();
        // A line without length is all start.
        if fraction.is_nan() { 0.0 } else { fraction.clamp(0.0, 1.0) }
    }

    /// Distance of a point \[m\].
    pub fn distance(&self, point: &Point2<f64>) -> f64 {
        nalgebra::distance(point, &self.at(self.nearest_fraction(point)))
    }

    /// How far a ray from `origin` \[m\] in `direction` \[rad\] runs until it hits, ends included.
    ///
    /// No ray slips between two lines with a common end. A ray that starts on the line hits it at
    /// 0, one that runs along it at its nearer end.
    pub fn cast(&self, origin: &Point2<f64>, direction: f64) -> Option<f64> {
        self.hit(&Ray::new(origin, direction))
    }

    #[inline]
    pub(crate) fn hit(&self, ray: &Ray) -> Option<f64> {
        let (a, b) = (self.start - ray.origin, self.end - ray.origin);
        // On which side of the ray each end lies: a common end of two lines lies on the same side
        // for both, whatever the rounding.
        let (side_a, side_b) = (a.perp(&ray.along), b.perp(&ray.along));
        if (side_a > 0.0 && side_b > 0.0) || (side_a < 0.0 && side_b < 0.0) {
            return None;
        }
        let (far_a, far_b) = (a.dot(&ray.along), b.dot(&ray.along));
        let across = side_b - side_a;
        if across.abs() <= 0.0 {
            return along_the_line(far_a, far_b);
        }
        let far = (far_a * side_b - far_b * side_a) / across;
        (far >= -ON_LINE).then_some(far.max(0.0))
    }

    /// Checks that both ends are valid coordinates, and different.
    pub(crate) fn checked(self) -> Result<Self> {
        for value in [self.start.x, self.start.y, self.end.x, self.end.y] {
            coordinate("end of a line [m]", value)?;
        }
        if self.has_length() {
            return Ok(self);
        }
        Err(crate::Error::LineWithoutLength { x: self.start.x, y: self.start.y })
    }

    /// Whether the ends are two positions, also where squares of numbers vanish.
    pub(crate) fn has_length(&self) -> bool {
        (self.end - self.start).norm_squared() > 0.0
    }
}

/// The nearer of two ends straight ahead, 0 between them.
fn along_the_line(far_a: f64, far_b: f64) -> Option<f64> {
    (far_a.max(far_b) >= -ON_LINE).then_some(far_a.min(far_b).max(0.0))
}

impl NormalForm {
    /// Signed distance of a point \[m\]: negative on the side of the origin.
    pub fn signed_distance(&self, point: &Point2<f64>) -> f64 {
        let (sin, cos) = self.alpha.sin_cos();
        point.coords.dot(&Vector2::new(cos, sin)) - self.r
    }
}

impl Bounded for LineSegment {
    fn bounds(&self) -> Bounds {
        Bounds { min: self.start.inf(&self.end), max: self.start.sup(&self.end) }
    }
}

const COLUMNS: [&str; 4] = ["x1", "y1", "x2", "y2"];

fn from_row(row: &Row<'_>) -> loc_core::Result<LineSegment> {
    let [x1, y1, x2, y2] = COLUMNS.map(|name| column(row, name));
    let line = LineSegment::new([x1?, y1?], [x2?, y2?]);
    if line.has_length() {
        return Ok(line);
    }
    let [_, _, x2, y2] = COLUMNS.map(|name| row.optional_text(name).unwrap_or_default());
    Err(row.error("x2,y2", "another point than x1,y1", &format!("{x2},{y2}")))
}
