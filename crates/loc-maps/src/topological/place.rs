//! Places and the edges between them.

use nalgebra::Point2;

/// What kind of place it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum PlaceKind {
    /// A room, where one stays.
    Room,
    /// A corridor, which leads from place to place.
    Corridor,
    /// A door, a narrow passage between two others.
    Door,
}

/// A place of a [`TopologicalMap`](super::TopologicalMap).
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Place {
    /// Its name, which no other place has.
    pub name: String,
    /// What kind of place it is.
    pub kind: PlaceKind,
    /// A point in it where a robot can stand \[m\].
    pub position: Point2<f64>,
    /// Its width \[m\], where known: of a door the clear width.
    pub width: Option<f64>,
    /// The corners of its outline in order \[m\], the last joined to the first; may be empty.
    pub outline: Vec<Point2<f64>>,
}

/// Two places that are neighbours.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Edge {
    /// The indices of the two places.
    pub between: [usize; 2],
    /// Length of the way from one to the other \[m\].
    pub length: f64,
    /// Points on the way from the first to the second \[m\]; none where it is straight.
    pub via: Vec<Point2<f64>>,
}

impl Edge {
    /// An edge between two places by their indices, with the length of the way \[m\].
    pub fn new(from: usize, to: usize, length: f64) -> Self {
        Edge { between: [from, to], length, via: Vec::new() }
    }
}

/// Length of a way from point to point \[m\].
pub(super) fn way_length(way: impl IntoIterator<Item = Point2<f64>>) -> f64 {
    let mut way = way.into_iter();
    let Some(mut at) = way.next() else { return 0.0 };
    way.map(|next| nalgebra::distance(&std::mem::replace(&mut at, next), &next)).sum()
}

impl PlaceKind {
    /// The word that stands for it in files.
    pub fn name(self) -> &'static str {
        match self {
            PlaceKind::Room => "room",
            PlaceKind::Corridor => "corridor",
            PlaceKind::Door => "door",
        }
    }
}

impl Place {
    /// A place at (x, y) \[m\], without outline or width.
    pub fn new(name: impl Into<String>, kind: PlaceKind, x: f64, y: f64) -> Self {
        let position = Point2::new(x, y);
        Place { name: name.into(), kind, position, width: None, outline: Vec::new() }
    }

    /// Area inside the outline \[m^2\].
    pub fn area(&self) -> f64 {
        let next = self.outline.iter().cycle().skip(1);
        let twice: f64 = self.outline.iter().zip(next).map(|(a, b)| a.coords.perp(&b.coords)).sum();
        0.5 * twice.abs()
    }

    /// Whether a point lies inside the outline (counting how often a ray crosses it).
    pub fn contains(&self, point: &Point2<f64>) -> bool {
        let corners = self.outline.iter();
        let next = self.outline.iter().cycle().skip(1);
        let crossed = corners.zip(next).filter(|(a, b)| {
            (a.y > point.y) != (b.y > point.y)
                && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x)
        });
        crossed.count() % 2 == 1
    }
}
