//! The topological map (C4): a graph of neighbouring places.
//!
//! People describe routes by places ("down the corridor, through the second door"), not by
//! coordinates. This map holds places (rooms, corridors, doors) and which of them are neighbours,
//! and finds the shortest path from one to another. It is drawn by hand in a TOML file, or
//! extracted from an occupancy grid by [`TopologicalMap::from_grid`], which takes narrow passages
//! for doors.
//!
//! ```
//! # #[cfg(feature = "serde")] {
//! use loc_maps::TopologicalMap;
//! let map = TopologicalMap::parse_toml("flat.toml", r#"
//!     [[place]]
//!     name = "kitchen"
//!     kind = "room"
//!     position = [1.0, 2.0]
//!
//!     [[place]]
//!     name = "kitchen door"
//!     kind = "door"
//!     position = [3.0, 2.0]
//!     width = 0.9
//!
//!     [[place]]
//!     name = "hall"
//!     kind = "corridor"
//!     position = [4.0, 5.0]
//!
//!     [[edge]]
//!     between = ["kitchen", "kitchen door"]
//!
//!     [[edge]]
//!     between = ["kitchen door", "hall"]
//!     length = 3.5 # around the table; the distance of the places else
//! "#)?;
//! let (kitchen, hall) = (map.find("kitchen").unwrap(), map.find("hall").unwrap());
//! let route = map.shortest_path(kitchen, hall).unwrap();
//! assert_eq!((route.places.len(), route.length), (3, 5.5));
//! # }
//! # Ok::<(), loc_maps::Error>(())
//! ```

mod extract;
#[cfg(feature = "serde")]
mod toml_file;

pub use extract::ExtractSettings;

use crate::bounds::coordinate;
use crate::{Bounds, Error, Result};
use loc_core::error::non_negative;
use nalgebra::Point2;
use std::collections::{HashMap, HashSet};

/// Places and the edges between neighbours.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "Stored", into = "Stored"))]
pub struct TopologicalMap {
    places: Vec<Place>,
    edges: Vec<Edge>,
    /// For every place its neighbours, as (place, length), in the order of the edges.
    neighbours: Vec<Vec<(usize, f64)>>,
    by_name: HashMap<String, usize>,
}

impl TopologicalMap {
    /// A map of places and of edges between them, which name places by their index.
    ///
    /// # Errors
    /// [`Error::DuplicatePlace`], [`Error::UnknownPlace`] and [`Error::UselessEdge`] (from a place
    /// to itself, or a second one between two places), and [`loc_core::Error::OutOfRange`] for
    /// coordinates, widths and lengths that cannot be.
    pub fn new(
        places: impl IntoIterator<Item = Place>,
        edges: impl IntoIterator<Item = Edge>,
    ) -> Result<Self> {
        let mut map = TopologicalMap::default();
        for place in places {
            map.add_place(place)?;
        }
        let mut joined = HashSet::new();
        for edge in edges {
            map.add_edge(edge, &mut joined)?;
        }
        Ok(map)
    }

    /// The places, in the order in which they were given.
    pub fn places(&self) -> &[Place] {
        &self.places
    }

    /// The edges, in the order in which they were given.
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// The index of the place with a name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.by_name.get(name).copied()
    }

    /// The neighbours of a place, with the length of the path to each \[m\]; none for an index that
    /// no place has.
    pub fn neighbours(&self, place: usize) -> &[(usize, f64)] {
        self.neighbours.get(place).map_or(&[], Vec::as_slice)
    }

    /// The places whose outline holds a point \[m\], smallest first: a room inside a ring of
    /// corridors before the ring.
    pub fn places_at(&self, point: &Point2<f64>) -> impl Iterator<Item = usize> {
        let places = self.places.iter().enumerate();
        let mut found: Vec<(usize, f64)> = places
            .filter(|(_, place)| place.contains(point))
            .map(|(index, place)| (index, place.area()))
            .collect();
        found.sort_by(|a, b| a.1.total_cmp(&b.1));
        found.into_iter().map(|(index, _)| index)
    }

    /// The place whose position is nearest to a point \[m\], with its distance \[m\].
    pub fn nearest(&self, point: &Point2<f64>) -> Option<(usize, f64)> {
        let far =
            |(index, place): (usize, &Place)| (index, nalgebra::distance(&place.position, point));
        self.places.iter().enumerate().map(far).min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The smallest box around all positions and outlines; `None` where there are no places.
    pub fn bounds(&self) -> Option<Bounds> {
        let points = |place: &Place| [place.position].into_iter().chain(place.outline.clone());
        Bounds::around(self.places.iter().flat_map(points))
    }

    fn add_place(&mut self, place: Place) -> Result<()> {
        for point in [&place.position].into_iter().chain(&place.outline) {
            coordinate("position of a place [m]", point.x)?;
            coordinate("position of a place [m]", point.y)?;
        }
        if let Some(width) = place.width {
            non_negative("width of a place [m]", width)?;
        }
        if self.by_name.insert(place.name.clone(), self.places.len()).is_some() {
            return Err(Error::DuplicatePlace { name: place.name });
        }
        self.places.push(place);
        self.neighbours.push(Vec::new());
        Ok(())
    }

    fn add_edge(&mut self, edge: Edge, joined: &mut HashSet<(usize, usize)>) -> Result<()> {
        let number = self.edges.len();
        let [from, to] = edge.between;
        let places = self.places.len();
        if let Some(found) = [from, to].into_iter().find(|&place| place >= places) {
            return Err(Error::UnknownPlace { edge: number, places, found });
        }
        if from == to || !joined.insert((from.min(to), from.max(to))) {
            let [from, to] = [from, to].map(|place| self.places[place].name.clone());
            return Err(Error::UselessEdge { edge: number, from, to });
        }
        non_negative("length of an edge [m]", edge.length)?;
        for value in edge.via.iter().flat_map(|point| [point.x, point.y]) {
            coordinate("point on an edge [m]", value)?;
        }
        self.neighbours[from].push((to, edge.length));
        self.neighbours[to].push((from, edge.length));
        self.edges.push(edge);
        Ok(())
    }

    /// The shortest path from one place to another (Dijkstra 1959), `None` where there is none.
    ///
    /// Buildings have at most some thousand places, so the nearest open place is found by a linear
    /// search.
    pub fn shortest_path(&self, from: usize, to: usize) -> Option<Route> {
        let count = self.places().len();
        if from >= count || to >= count {
            return None;
        }
        let mut length = vec![f64::INFINITY; count];
        let mut before = vec![from; count];
        let mut open: Vec<usize> = (0..count).collect();
        length[from] = 0.0;
        while let Some(nearest) = take_nearest(&mut open, &length) {
            if nearest == to || length[nearest].is_infinite() {
                break;
            }
            for &(next, step) in self.neighbours(nearest) {
                if length[nearest] + step < length[next] {
                    length[next] = length[nearest] + step;
                    before[next] = nearest;
                }
            }
        }
        length[to]
            .is_finite()
            .then(|| Route { places: trace(&before, from, to), length: length[to] })
    }
}

/// The serialized form: places and edges, from which the rest is computed.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
struct Stored {
    places: Vec<Place>,
    edges: Vec<Edge>,
}

#[cfg(feature = "serde")]
impl TryFrom<Stored> for TopologicalMap {
    type Error = Error;
    fn try_from(stored: Stored) -> Result<Self> {
        TopologicalMap::new(stored.places, stored.edges)
    }
}

#[cfg(feature = "serde")]
impl From<TopologicalMap> for Stored {
    fn from(map: TopologicalMap) -> Self {
        Stored { places: map.places, edges: map.edges }
    }
}

/// The kind of a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum PlaceKind {
    /// A room.
    Room,
    /// A corridor, which leads from place to place.
    Corridor,
    /// A door, a narrow passage between two others.
    Door,
}

/// A place of a [`TopologicalMap`].
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Place {
    /// Its name, which no other place has.
    pub name: String,
    /// Its kind.
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
    /// Length of the path from one to the other \[m\].
    pub length: f64,
    /// Points on the path from the first to the second \[m\]; none where it is straight.
    pub via: Vec<Point2<f64>>,
}

impl Edge {
    /// An edge between two places by their indices, with the length of the path \[m\].
    pub fn new(from: usize, to: usize, length: f64) -> Self {
        Edge { between: [from, to], length, via: Vec::new() }
    }
}

/// Length of a path from point to point \[m\].
fn path_length(points: impl IntoIterator<Item = Point2<f64>>) -> f64 {
    let mut points = points.into_iter();
    let Some(mut at) = points.next() else { return 0.0 };
    points.map(|next| nalgebra::distance(&std::mem::replace(&mut at, next), &next)).sum()
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

/// A path through a [`TopologicalMap`].
#[derive(Debug, Clone, PartialEq)]
pub struct Route {
    /// The places from start to goal, both included.
    pub places: Vec<usize>,
    /// Its length \[m\].
    pub length: f64,
}

/// Removes and returns the open place with the shortest path so far.
fn take_nearest(open: &mut Vec<usize>, length: &[f64]) -> Option<usize> {
    let by_length = |a: &usize, b: &usize| length[open[*a]].total_cmp(&length[open[*b]]);
    let place = (0..open.len()).min_by(by_length)?;
    Some(open.swap_remove(place))
}

fn trace(before: &[usize], from: usize, to: usize) -> Vec<usize> {
    let mut places = vec![to];
    let mut at = to;
    while at != from {
        at = before[at];
        places.push(at);
    }
    places.reverse();
    places
}
