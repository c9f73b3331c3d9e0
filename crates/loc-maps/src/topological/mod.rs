//! The topological map (C4): a graph of neighbouring places.
//!
//! People do not give coordinates, they say "down the corridor, through the second door". This map
//! knows places (rooms, corridors, doors) and which of them are neighbours, and finds the shortest
//! way from one to another. It is drawn by hand in a TOML file, or extracted from an occupancy
//! grid by [`TopologicalMap::from_grid`], which takes narrow passages for doors.
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
mod place;
mod route;
#[cfg(feature = "serde")]
mod toml_file;

pub use extract::ExtractSettings;
pub use place::{Edge, Place, PlaceKind};
pub use route::Route;

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

    /// The neighbours of a place, with the length of the way to each \[m\]; none for an index that
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
}

/// What is stored of a map: the rest follows from it.
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
