//! The landmark map (C6): numbered landmarks at known positions.
//!
//! Positions have a height, for cameras that look up and for lateration in space; planar methods
//! ignore it. The file format is CSV with the columns `id,x,y` and, if wanted, `z`.
//!
//! ```
//! use loc_maps::{Landmark, LandmarkMap};
//! let map = LandmarkMap::new([Landmark::planar(4, 1.0, 2.0), Landmark::planar(2, 0.0, 0.5)])?;
//! assert_eq!(map.to_csv(), "id,x,y,z\n2,0,0.5,0\n4,1,2,0\n");
//! # Ok::<(), loc_maps::Error>(())
//! ```
//!
//! A landmark map does not contain the walls that hide landmarks. [`Occluded`] combines it with a
//! map that has walls: from a position only landmarks with a free line of sight are visible.
//!
//! ```
//! use loc_maps::{Landmark, LandmarkMap, Occluded};
//! use loc_sensors::world::{LandmarkWorld, Room};
//! let landmarks = LandmarkMap::new([Landmark::planar(1, 2.9, 0.0), Landmark::planar(2, 5.0, 0.0)])?;
//! let room = Room::new([-3.0, -2.0], [3.0, 2.0])?;
//! let mut seen = Vec::new();
//! let world = Occluded { landmarks: &landmarks, walls: &room, slack: 0.1 };
//! world.visit_landmarks(&[0.0, 0.0].into(), 10.0, &mut |id, _| seen.push(id));
//! assert_eq!(seen, [1]);
//! # Ok::<(), loc_maps::Error>(())
//! ```

use crate::{Error, Result};
use loc_core::table::Table;
use loc_sensors::world::{LandmarkWorld, RangeWorld};
use nalgebra::{Point2, Point3};
use std::path::{Path, PathBuf};

const COLUMNS: [&str; 4] = ["id", "x", "y", "z"];

/// A landmark with its number (known data association).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Landmark {
    /// Its number.
    pub id: u32,
    /// Its position in the map frame \[m\].
    pub position: Point3<f64>,
}

/// Numbered landmarks, in order of their numbers.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "Vec<Landmark>", into = "Vec<Landmark>"))]
pub struct LandmarkMap {
    landmarks: Vec<Landmark>,
}

impl Landmark {
    /// A landmark at height 0, at (x, y) \[m\].
    pub fn planar(id: u32, x: f64, y: f64) -> Self {
        Landmark { id, position: Point3::new(x, y, 0.0) }
    }
}

impl LandmarkMap {
    /// A map from landmarks in any order.
    ///
    /// # Errors
    /// [`Error::DuplicateLandmark`], and [`loc_core::Error::OutOfRange`] for positions that are
    /// not finite.
    pub fn new(landmarks: impl IntoIterator<Item = Landmark>) -> Result<Self> {
        let mut landmarks: Vec<Landmark> = landmarks.into_iter().collect();
        for landmark in &landmarks {
            for coordinate in landmark.position.iter() {
                loc_core::error::finite("position of a landmark [m]", *coordinate)?;
            }
        }
        landmarks.sort_by_key(|landmark| landmark.id);
        match landmarks.windows(2).find(|pair| pair[0].id == pair[1].id) {
            Some(pair) => Err(Error::DuplicateLandmark { id: pair[0].id }),
            None => Ok(LandmarkMap { landmarks }),
        }
    }

    /// The landmark with a number.
    pub fn get(&self, id: u32) -> Option<&Landmark> {
        let index = self.landmarks.binary_search_by_key(&id, |landmark| landmark.id).ok()?;
        self.landmarks.get(index)
    }

    /// The landmarks in order of their numbers.
    pub fn iter(&self) -> std::slice::Iter<'_, Landmark> {
        self.landmarks.iter()
    }

    /// Number of landmarks.
    pub fn len(&self) -> usize {
        self.landmarks.len()
    }

    /// Whether there are no landmarks.
    pub fn is_empty(&self) -> bool {
        self.landmarks.is_empty()
    }

    /// The landmark nearest to a point of the plane \[m\], with its distance \[m\].
    pub fn nearest(&self, point: &Point2<f64>) -> Option<(&Landmark, f64)> {
        self.landmarks
            .iter()
            .map(|landmark| (landmark, nalgebra::distance(point, &landmark.position.xy())))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Reads a CSV file with the columns `id,x,y` and, if wanted, `z` \[m\].
    ///
    /// # Errors
    /// [`loc_core::Error`] for files that cannot be read, with line and column for what cannot be
    /// understood, and for a number that occurs twice or a file without landmarks.
    pub fn read_csv(file: impl AsRef<Path>) -> Result<Self> {
        LandmarkMap::from_table(&Table::read(file, &COLUMNS)?)
    }

    /// The same from a text; `file` is only named in errors.
    ///
    /// # Errors
    /// As [`LandmarkMap::read_csv`].
    pub fn parse_csv(file: impl Into<PathBuf>, text: &str) -> Result<Self> {
        LandmarkMap::from_table(&Table::parse(file, text, &COLUMNS))
    }

    /// The map as the text of a CSV file, every number to its last digit.
    pub fn to_csv(&self) -> String {
        let mut text = String::from("id,x,y,z\n");
        for Landmark { id, position } in &self.landmarks {
            text += &format!("{id},{},{},{}\n", position.x, position.y, position.z);
        }
        text
    }

    fn from_table(table: &Table) -> Result<Self> {
        let table = table.clone().with_optional(1);
        let mut landmarks: Vec<Landmark> = Vec::new();
        for row in table.rows() {
            let row = row?;
            let id = row.whole_number("id")?;
            let z = if row.optional_text("z").is_some() { row.number("z")? } else { 0.0 };
            if landmarks.iter().any(|known| known.id == id) {
                let expected = "a number that no other landmark has";
                return Err(row.error("id", expected, &id.to_string()).into());
            }
            let position = Point3::new(row.number("x")?, row.number("y")?, z);
            landmarks.push(Landmark { id, position });
        }
        if landmarks.is_empty() {
            let file = table.file().to_owned();
            return Err(loc_core::Error::Empty { file, what: "landmarks" }.into());
        }
        LandmarkMap::new(landmarks)
    }
}

impl LandmarkWorld for LandmarkMap {
    fn visit_landmarks(
        &self,
        center: &Point2<f64>,
        radius: f64,
        visit: &mut dyn FnMut(u32, Point2<f64>),
    ) {
        for landmark in &self.landmarks {
            let position = landmark.position.xy();
            if nalgebra::distance(center, &position) <= radius {
                visit(landmark.id, position);
            }
        }
    }
}

impl TryFrom<Vec<Landmark>> for LandmarkMap {
    type Error = Error;
    fn try_from(landmarks: Vec<Landmark>) -> Result<Self> {
        LandmarkMap::new(landmarks)
    }
}

impl From<LandmarkMap> for Vec<Landmark> {
    fn from(map: LandmarkMap) -> Self {
        map.landmarks
    }
}

/// The landmarks of one map behind the walls of another.
#[derive(Debug, Clone, Copy)]
pub struct Occluded<'a, L: ?Sized, W: ?Sized> {
    /// The landmarks.
    pub landmarks: &'a L,
    /// The walls.
    pub walls: &'a W,
    /// A wall this close before a landmark does not hide it \[m\]: landmarks hang on walls.
    pub slack: f64,
}

impl<L: LandmarkWorld + ?Sized, W: RangeWorld + ?Sized> LandmarkWorld for Occluded<'_, L, W> {
    fn visit_landmarks(
        &self,
        center: &Point2<f64>,
        radius: f64,
        visit: &mut dyn FnMut(u32, Point2<f64>),
    ) {
        self.landmarks.visit_landmarks(center, radius, &mut |id, position| {
            let offset = position - center;
            let open = offset.norm() - self.slack;
            let hidden =
                open > 0.0 && self.walls.cast(center, offset.y.atan2(offset.x), open).is_some();
            if !hidden {
                visit(id, position);
            }
        });
    }
}
