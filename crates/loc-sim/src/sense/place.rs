//! The world that a sensor is put into.

use crate::config::field;
use crate::{Error, Result};
use loc_core::Pose2;
use loc_maps::grid::{Occupancy, io};
use loc_maps::worlds::{self, WorldSettings};
use loc_maps::{DistanceMap, LandmarkMap, LineMap, LineSegment, OccupancyGrid, RayCaster};
use loc_sensors::world::RangeWorld;
use nalgebra::Point2;
use std::f64::consts::TAU;
use std::path::Path;

/// Names of the built-in worlds; the first one is taken where none is named.
pub const WORLDS: [&str; 5] = ["room", "office", "corridor", "soccer-field", "hall-of-mirrors"];

/// Beyond this a place is wide enough \[m\].
const WIDE: f64 = 5.0;
/// How many places, and at each how many headings, compete for the best view.
const PLACES: usize = 300;
const HEADINGS: usize = 16;

/// A grid, prepared for casting rays and for distances to its walls.
#[derive(Debug)]
pub struct Place {
    name: String,
    grid: OccupancyGrid,
    walls: RayCaster,
    clearance: DistanceMap,
    landmarks: Option<LandmarkMap>,
}

impl Place {
    /// A map of map_server.
    ///
    /// # Errors
    /// Those of [`io::load`].
    pub fn open(map: &Path) -> Result<Self> {
        let name = map.file_stem().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        Place::new(name, io::load(map)?)
    }

    /// A built-in world.
    ///
    /// # Errors
    /// [`Error::UnknownName`] with the names there are.
    pub fn named(name: &str, seed: u64) -> Result<Self> {
        if name == "room" {
            return Place::new(name.to_owned(), room()?);
        }
        let settings = WorldSettings::suited_to(name).map_err(|_| Error::UnknownName {
            what: "world",
            expected: WORLDS.join(", "),
            found: name.into(),
        })?;
        let world = worlds::by_name(name, &WorldSettings { seed, ..settings })?;
        let landmarks = (!world.landmarks.is_empty()).then_some(world.landmarks);
        Ok(Place { landmarks, ..Place::new(name.to_owned(), world.grid)? })
    }

    fn new(name: String, grid: OccupancyGrid) -> Result<Self> {
        let blocks = |value| Occupancy::of(value) != Occupancy::Free;
        let clearance = DistanceMap::to_cells(&grid, WIDE, blocks)?;
        Ok(Place { name, walls: RayCaster::new(&grid), clearance, grid, landmarks: None })
    }

    /// Name of the map or world.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The map.
    pub fn grid(&self) -> &OccupancyGrid {
        &self.grid
    }

    /// The map, prepared for casting rays.
    pub fn walls(&self) -> &RayCaster {
        &self.walls
    }

    /// The landmarks that belong to the world, where it has any.
    pub fn landmarks(&self) -> Option<&LandmarkMap> {
        self.landmarks.as_ref()
    }

    /// Distance to what is not free \[m\], at most 5 m; 0 off the map.
    pub fn clearance(&self, point: &Point2<f64>) -> f64 {
        self.clearance.distance_at(point).unwrap_or(0.0)
    }

    /// Lets a pose in free space pass.
    ///
    /// # Errors
    /// [`Error::Config`] for one in a wall, in unknown space or off the map.
    pub fn check(&self, pose: Pose2) -> Result<Pose2> {
        let point = pose.position();
        let found = match self.grid.value_at(&point).map(Occupancy::of) {
            Some(Occupancy::Free) => return Ok(pose),
            Some(Occupancy::Occupied) => "a wall",
            Some(Occupancy::Unknown) => "unknown space",
            None => "a place off the map",
        };
        let corners = self.grid.frame().corners();
        let range = |of: fn(&Point2<f64>) -> f64| {
            let values = || corners.iter().map(of);
            let min = values().fold(f64::INFINITY, f64::min);
            format!("{min:.1} to {:.1} m", values().fold(f64::NEG_INFINITY, f64::max))
        };
        let (x, y) = (range(|corner| corner.x), range(|corner| corner.y));
        let expected = format!("a place in free space of {} (x {x}, y {y})", self.name);
        Err(field("--pose", &expected, &format!("{found} at {:.2},{:.2}", point.x, point.y)))
    }

    /// The free place and heading with the highest score, among those with a clearance of at
    /// least `clearance` \[m\], or as much as there is.
    ///
    /// # Errors
    /// [`Error::Config`] for a map without free space.
    pub fn best_view(&self, clearance: f64, score: impl Fn(Pose2) -> f64) -> Result<Pose2> {
        let places = self.places(clearance);
        let headings = (0..HEADINGS).map(|k| k as f64 * TAU / HEADINGS as f64);
        let poses = places.iter().flat_map(|place| {
            headings.clone().map(|heading| Pose2::new(place.x, place.y, heading))
        });
        let scored = poses.map(|pose| (score(pose), pose));
        let best = scored.reduce(|best, next| if next.0 > best.0 { next } else { best });
        best.map(|(_, pose)| pose).ok_or_else(|| field("map", "a cell of free space", "none"))
    }

    /// The widest place, looking along its longest way.
    ///
    /// # Errors
    /// As [`best_view`](Place::best_view).
    pub fn middle(&self) -> Result<Pose2> {
        self.best_view(WIDE, |pose| self.range(pose, 30.0))
    }

    /// Distance to the wall straight ahead \[m\], at most `reach`.
    pub fn range(&self, pose: Pose2, reach: f64) -> f64 {
        self.walls.cast(&pose.position(), pose.theta, reach).unwrap_or(reach)
    }

    /// Ranges in 25 directions over a field of view `fov` \[rad\], at most `reach` \[m\].
    pub fn fan(&self, pose: Pose2, fov: f64, reach: f64) -> Vec<f64> {
        let heading = |k: i32| pose.theta + f64::from(k) / 24.0 * fov;
        let range = |k| self.range(Pose2::new(pose.x, pose.y, heading(k)), reach);
        (-12..=12).map(range).collect()
    }

    /// Centres of free cells that have the clearance, or nearly the largest one.
    fn places(&self, wanted: f64) -> Vec<Point2<f64>> {
        let free = || self.grid.centers_of(Occupancy::Free);
        let widest = free().map(|place| self.clearance(&place)).fold(0.0, f64::max);
        let clearance = wanted.min(0.9 * widest);
        let fitting: Vec<_> = free().filter(|place| self.clearance(place) >= clearance).collect();
        let step = fitting.len().div_ceil(PLACES).max(1);
        fitting.into_iter().skip(step / 2).step_by(step).collect()
    }
}

/// Two rooms with a door between them, a slanted wall, pillars and a table.
fn room() -> Result<OccupancyGrid> {
    let corner = |x: f64, y: f64| Point2::new(x, y);
    let line = |a: (f64, f64), b: (f64, f64)| LineSegment {
        start: corner(a.0, a.1),
        end: corner(b.0, b.1),
    };
    let closed = |corners: &[(f64, f64)]| -> Vec<LineSegment> {
        let next = corners.iter().cycle().skip(1);
        corners.iter().zip(next).map(|(&a, &b)| line(a, b)).collect()
    };
    let pillar = |x: f64, y: f64| closed(&[(x, y), (x + 0.4, y), (x + 0.4, y + 0.4), (x, y + 0.4)]);
    let mut lines = closed(&[(0.0, 0.0), (12.0, 0.0), (12.0, 6.5), (10.5, 8.0), (0.0, 8.0)]);
    lines.extend([line((7.0, 0.0), (7.0, 3.2)), line((7.0, 4.4), (7.0, 8.0))]);
    lines.extend([line((0.0, 5.5), (1.6, 5.5)), line((1.6, 5.5), (1.6, 6.2))]);
    lines.extend([pillar(2.4, 2.2), pillar(4.6, 5.6)].concat());
    lines.extend(closed(&[(9.0, 2.0), (10.0, 2.0), (10.0, 2.8), (9.0, 2.8)]));
    lines.extend(closed(&[(4.4, 0.8), (5.1, 1.2), (4.8, 1.7), (4.1, 1.3)]));
    Ok(LineMap::new(lines)?.to_grid(0.05, 0.0)?)
}
