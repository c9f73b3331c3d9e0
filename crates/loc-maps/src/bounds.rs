//! Boxes along the axes of the map: how far a map reaches.
//!
//! Pictures, grids and search indices are built from the box around a map.
//!
//! ```
//! use loc_maps::Bounds;
//! let bounds = Bounds::around([[1.0, 2.0].into(), [-3.0, 5.0].into()]).unwrap();
//! assert_eq!((bounds.width(), bounds.height()), (4.0, 3.0));
//! assert!(bounds.contains(&[0.0, 2.0].into()));
//! ```

use nalgebra::{Point2, Vector2};

/// Largest coordinate of a map \[m\]; up to it, squares of distances
/// are far from overflow, and a nanometre still counts.
const MAX_COORDINATE: f64 = 1e6;

/// A box along the axes, its border included.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Bounds {
    /// The corner with the smallest coordinates \[m\].
    pub min: Point2<f64>,
    /// The corner with the greatest coordinates \[m\].
    pub max: Point2<f64>,
}

impl Bounds {
    /// The smallest box around points; `None` where there are none.
    pub fn around(points: impl IntoIterator<Item = Point2<f64>>) -> Option<Self> {
        points.into_iter().map(|p| Bounds { min: p, max: p }).reduce(Bounds::union)
    }

    /// The smallest box around two.
    #[must_use]
    pub fn union(self, other: Bounds) -> Bounds {
        Bounds { min: self.min.inf(&other.min), max: self.max.sup(&other.max) }
    }

    /// The box grown by `margin` \[m\] on every side.
    #[must_use]
    pub fn grown(self, margin: f64) -> Bounds {
        let by = Vector2::repeat(margin);
        Bounds { min: self.min - by, max: self.max + by }
    }

    /// Extent along x \[m\].
    pub fn width(&self) -> f64 {
        self.max.x - self.min.x
    }

    /// Extent along y \[m\].
    pub fn height(&self) -> f64 {
        self.max.y - self.min.y
    }

    /// The middle \[m\].
    pub fn center(&self) -> Point2<f64> {
        nalgebra::center(&self.min, &self.max)
    }

    /// Whether a point lies inside or on the border.
    pub fn contains(&self, point: &Point2<f64>) -> bool {
        self.squared_distance(point) <= 0.0
    }

    /// Squared distance from a point to the box \[m^2\], 0 inside.
    pub(crate) fn squared_distance(&self, point: &Point2<f64>) -> f64 {
        let outside = |p: f64, min: f64, max: f64| (min - p).max(p - max).max(0.0);
        let dx = outside(point.x, self.min.x, self.max.x);
        let dy = outside(point.y, self.min.y, self.max.y);
        dx * dx + dy * dy
    }
}

/// Checks that a coordinate of a map is a number within what robots live in.
pub(crate) fn coordinate(what: &'static str, value: f64) -> loc_core::Result<f64> {
    let expected = "a finite number from -1e6 to 1e6";
    if value.abs() <= MAX_COORDINATE {
        Ok(value)
    } else {
        Err(loc_core::Error::OutOfRange { what, expected, found: value })
    }
}

/// A coordinate from a column of a text table, checked in the same way.
pub(crate) fn column(row: &loc_core::table::Row<'_>, name: &str) -> loc_core::Result<f64> {
    let value = row.number(name)?;
    let expected = "a number from -1e6 to 1e6";
    coordinate("coordinate [m]", value)
        .map_err(|_| row.error(name, expected, row.optional_text(name).unwrap_or_default()))
}
