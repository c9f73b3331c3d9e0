//! The building of a tour: its walls, the paths through it, and the driver that follows them.

use crate::config::field;
use crate::{Error, Result};
use loc_core::error::positive;
use loc_core::motion::Integration;
use loc_core::random::ChaCha8Rng;
use loc_core::{Pose2, Twist2, angle};
use loc_maps::grid::{GridFrame, Occupancy, io};
use loc_maps::worlds::WorldSettings;
use loc_maps::{DistanceMap, LandmarkMap, OccupancyGrid, RayCaster, worlds};
use nalgebra::Point2;
use rand::RngExt;
use serde::Deserialize;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::path::Path;
use std::sync::Arc;

/// Largest clearance that is computed \[m\].
const WIDE: f64 = 3.0;

/// A generated world, see [`loc_maps::worlds`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorldConfig {
    /// Its name: `office`, `corridor`, `soccer-field` or `hall-of-mirrors`.
    pub name: String,
    /// Number of columns; what suits the kind of world where left out.
    pub width: Option<usize>,
    /// Number of rows.
    pub height: Option<usize>,
    /// Side of a cell \[m\].
    pub resolution: Option<f64>,
    /// What its details are drawn from, whatever the seed of the run; 1 where left out.
    pub seed: Option<u64>,
}

/// A grid with its walls for rays and its room for robots.
#[derive(Debug)]
pub struct TourWorld {
    pub(super) grid: Arc<OccupancyGrid>,
    pub(super) landmarks: Arc<LandmarkMap>,
    pub(crate) walls: RayCaster,
    clearance: DistanceMap,
}

impl WorldConfig {
    /// The size of the world.
    ///
    /// # Errors
    /// [`Error::UnknownName`] with the names there are.
    pub fn settings(&self) -> Result<WorldSettings> {
        let suited = WorldSettings::suited_to(&self.name).map_err(|_| Error::UnknownName {
            what: "world",
            expected: worlds::NAMES.join(", "),
            found: self.name.clone(),
        })?;
        Ok(WorldSettings {
            width: self.width.unwrap_or(suited.width),
            height: self.height.unwrap_or(suited.height),
            resolution: self.resolution.unwrap_or(suited.resolution),
            seed: self.seed.unwrap_or(suited.seed),
        })
    }
}

impl TourWorld {
    /// A generated world, or the map of map_server in a file: one of the two.
    ///
    /// # Errors
    /// [`Error::Config`] for both or none, and those of the world or the file.
    pub fn open(world: Option<&WorldConfig>, map: Option<&Path>) -> Result<Self> {
        match (world, map) {
            (Some(world), None) => {
                let world = worlds::by_name(&world.name, &world.settings()?)?;
                let landmarks = Arc::new(world.landmarks);
                Ok(TourWorld { landmarks, ..TourWorld::new(world.grid)? })
            }
            (None, Some(file)) => TourWorld::new(io::load(file)?),
            (Some(_), Some(_)) => Err(field("world, map", "one of the two", "both")),
            (None, None) => Err(field("world, map", "one of the two", "none")),
        }
    }

    /// A grid as a world, without landmarks.
    ///
    /// # Errors
    /// Those of [`DistanceMap::to_cells`].
    pub fn new(grid: OccupancyGrid) -> Result<Self> {
        let blocks = |value| Occupancy::of(value) != Occupancy::Free;
        let clearance = DistanceMap::to_cells(&grid, WIDE, blocks)?;
        let (walls, landmarks) = (RayCaster::new(&grid), Arc::default());
        Ok(TourWorld { grid: Arc::new(grid), landmarks, walls, clearance })
    }

    /// The map.
    pub fn grid(&self) -> &Arc<OccupancyGrid> {
        &self.grid
    }

    /// The map, prepared for casting rays.
    pub fn walls(&self) -> &RayCaster {
        &self.walls
    }

    /// Distance to what is not free \[m\], at most 3 m; 0 off the map.
    pub fn clearance(&self, point: &Point2<f64>) -> f64 {
        self.clearance.distance_at(point).unwrap_or(0.0)
    }
}

/// Side of the squares \[m\], as far as the map's cells allow.
const SQUARE: f64 = 0.1;
/// Clearance beyond the robot's radius from which on a square has no extra cost \[m\].
const COMFORT: f64 = 0.4;
/// Cost factor of a path along a wall.
const RELUCTANCE: f64 = 4.0;
/// Largest distance of a configured position from the free squares \[m\].
const SNAP: f64 = 1.0;
const DIAGONAL: f64 = std::f64::consts::SQRT_2;

/// Path planning in squares of about 10 cm.
///
/// Squares with room for the robot are connected to their eight neighbours; tours use the largest
/// connected part. Paths are found by A* (Hart, Nilsson and Raphael, 1968); squares near walls cost
/// more, so that paths lead through the middle of doors.
#[derive(Debug)]
pub(super) struct Roads {
    frame: GridFrame,
    /// Cost factor of a square; 0 where the robot does not fit.
    cost: Vec<f32>,
    /// The squares of the largest part.
    places: Vec<u32>,
}

impl Roads {
    /// The roads for a robot that keeps `radius` \[m\] from walls.
    pub(super) fn new(world: &TourWorld, radius: f64) -> Result<Self> {
        let map = world.grid.frame();
        let square = SQUARE.max(map.resolution());
        let across = |cells: usize| (cells as f64 * map.resolution() / square).ceil() as usize;
        let (width, height) = (across(map.width()), across(map.height()));
        let frame = GridFrame::new(width, height, square, map.origin())?;
        let room = frame.cells().map(|cell| world.clearance(&frame.center(cell)));
        let cost = room.map(|room| match room - radius {
            spare if spare < 0.0 => 0.0,
            spare => (1.0 + RELUCTANCE * (1.0 - spare / COMFORT).max(0.0)) as f32,
        });
        let mut roads = Roads { frame, cost: cost.collect(), places: Vec::new() };
        roads.places = roads.largest_part();
        if roads.places.is_empty() {
            let expected = format!("free space for a robot of radius {radius} m");
            return Err(field("tour.world", &expected, "none"));
        }
        Ok(roads)
    }

    /// A random position on the roads, uniformly.
    pub(super) fn draw(&self, rng: &mut ChaCha8Rng) -> Point2<f64> {
        self.center(self.places[rng.random_range(0..self.places.len())])
    }

    /// The nearest position on the roads.
    ///
    /// # Errors
    /// [`crate::Error::Config`] where that is farther than 1 m.
    pub(super) fn nearest(&self, key: &str, point: Point2<f64>) -> Result<Point2<f64>> {
        let centers = self.places.iter().map(|&square| self.center(square));
        let far = |place: &Point2<f64>| nalgebra::distance(place, &point);
        let nearest = centers.min_by(|a, b| far(a).total_cmp(&far(b)));
        nearest.filter(|place| far(place) < SNAP).ok_or_else(|| {
            let found = format!("{:.2}, {:.2}", point.x, point.y);
            field(key, "a place within 1 m of where the robot can drive", &found)
        })
    }

    /// The cheapest path from one position on the roads to another, square by square; `None` where
    /// one of them is not on the roads.
    pub(super) fn way(&self, from: Point2<f64>, to: Point2<f64>) -> Option<Vec<Point2<f64>>> {
        let (start, goal) = (self.square_at(from)?, self.square_at(to)?);
        let mut best = vec![f32::INFINITY; self.cost.len()];
        let mut came_from = vec![start; self.cost.len()];
        let mut open = BinaryHeap::new();
        best[start as usize] = 0.0;
        open.push(Reverse((0_u32, start)));
        while let Some(Reverse((_, square))) = open.pop() {
            if square == goal {
                return Some(self.trace(&came_from, start, goal));
            }
            let so_far = best[square as usize];
            for (next, length) in self.neighbours(square) {
                let mean = 0.5 * (self.cost[square as usize] + self.cost[next as usize]);
                let cost = so_far + mean * length as f32;
                if cost < best[next as usize] {
                    best[next as usize] = cost;
                    came_from[next as usize] = square;
                    let estimate = f64::from(cost) + self.steps_between(next, goal);
                    // A resolution of thousandths of a square is sufficient.
                    open.push(Reverse(((1e3 * estimate) as u32, next)));
                }
            }
        }
        None
    }

    fn trace(&self, came_from: &[u32], start: u32, goal: u32) -> Vec<Point2<f64>> {
        let mut way = vec![self.center(goal)];
        let mut square = goal;
        while square != start {
            square = came_from[square as usize];
            way.push(self.center(square));
        }
        way.reverse();
        way
    }

    fn largest_part(&self) -> Vec<u32> {
        let mut seen = vec![false; self.cost.len()];
        let mut largest = Vec::new();
        for first in 0..self.cost.len() {
            if seen[first] || self.cost[first] <= 0.0 {
                continue;
            }
            // A grid has at most 2^28 cells.
            let mut part = vec![first as u32];
            seen[first] = true;
            let mut done = 0;
            while let Some(&square) = part.get(done) {
                done += 1;
                for (next, _) in self.neighbours(square) {
                    if !std::mem::replace(&mut seen[next as usize], true) {
                        part.push(next);
                    }
                }
            }
            if part.len() > largest.len() {
                largest = part;
            }
        }
        largest
    }

    /// The squares beside one that have room, with their distances \[squares\].
    fn neighbours(&self, square: u32) -> impl Iterator<Item = (u32, f64)> + '_ {
        let (column, row) = self.column_row(square);
        let (width, height) = (self.frame.width() as i64, self.frame.height() as i64);
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
        around.filter(|&step| step != (0, 0)).filter_map(move |(dx, dy)| {
            let (x, y) = (column + dx, row + dy);
            let inside = (0..width).contains(&x) && (0..height).contains(&y);
            let next = inside.then_some((y * width + x) as u32)?;
            let length = if dx != 0 && dy != 0 { DIAGONAL } else { 1.0 };
            (self.cost[next as usize] > 0.0).then_some((next, length))
        })
    }

    fn steps_between(&self, a: u32, b: u32) -> f64 {
        let ((ax, ay), (bx, by)) = (self.column_row(a), self.column_row(b));
        ((ax - bx) as f64).hypot((ay - by) as f64)
    }

    fn column_row(&self, square: u32) -> (i64, i64) {
        let width = self.frame.width() as i64;
        (i64::from(square) % width, i64::from(square) / width)
    }

    fn center(&self, square: u32) -> Point2<f64> {
        let (column, row) = self.column_row(square);
        self.frame.to_map(column as f64 + 0.5, row as f64 + 0.5)
    }

    /// The square of a point, or the nearest one with room: a robot is never exactly on its path.
    fn square_at(&self, point: Point2<f64>) -> Option<u32> {
        let cell = self.frame.cell_at(&point)?;
        let square = self.frame.index(cell)? as u32;
        if self.cost[square as usize] > 0.0 {
            return Some(square);
        }
        let far = |next: &u32| nalgebra::distance(&self.center(*next), &point);
        self.places.iter().copied().min_by(|a, b| far(a).total_cmp(&far(b)))
    }
}

/// Look-ahead distance of pure pursuit \[m\].
const AHEAD: f64 = 0.45;
/// Distance from the last point at which a path ends \[m\].
const ARRIVED: f64 = 0.15;
/// Direction change above which the robot turns on the spot \[rad\].
const TURN_FIRST: f64 = 0.9;
/// Turn rate per heading error towards the point \[1/s\].
const STEERING: f64 = 2.5;

/// Limits of the robot's motion.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RobotConfig {
    /// The robot keeps this far from walls \[m\].
    pub radius: f64,
    /// Speed where nothing is in the way \[m/s\].
    pub speed: f64,
    /// Largest turn rate \[rad/s\].
    #[serde(with = "loc_core::settings::angle_per_s")]
    pub turn: f64,
    /// Change of the speed \[m/s^2\].
    pub acceleration: f64,
    /// Change of the turn rate \[rad/s^2\].
    #[serde(with = "loc_core::settings::angle_per_s2")]
    pub turn_acceleration: f64,
}

impl Default for RobotConfig {
    /// A small service robot.
    fn default() -> Self {
        RobotConfig {
            radius: 0.3,
            speed: 0.7,
            turn: 70_f64.to_radians(),
            acceleration: 0.8,
            turn_acceleration: 200_f64.to_radians(),
        }
    }
}

impl RobotConfig {
    /// Checks every value.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] with the key.
    pub(super) fn check(&self) -> crate::Result<()> {
        positive("tour.robot.radius", self.radius)?;
        positive("tour.robot.speed", self.speed)?;
        positive("tour.robot.turn", self.turn)?;
        positive("tour.robot.acceleration", self.acceleration)?;
        positive("tour.robot.turn_acceleration", self.turn_acceleration)?;
        Ok(())
    }
}

/// Follows a path: steers towards a point ahead on it (pure pursuit, Coulter 1992), slows down in
/// turns, and turns on the spot where the path changes direction.
#[derive(Debug)]
pub(super) struct Driver {
    robot: RobotConfig,
    way: Vec<Point2<f64>>,
    /// The point that the robot steers to.
    next: usize,
    twist: Twist2,
}

impl Driver {
    /// A robot at rest.
    pub(super) fn new(robot: RobotConfig) -> Self {
        Driver { robot, way: Vec::new(), next: 0, twist: Twist2::ZERO }
    }

    /// Starts a path.
    pub(super) fn follow(&mut self, way: Vec<Point2<f64>>) {
        (self.way, self.next) = (way, 0);
    }

    /// Stops at once, for a kidnapping.
    pub(super) fn stop(&mut self) {
        self.follow(Vec::new());
        self.twist = Twist2::ZERO;
    }

    /// Whether a robot at `pose` is at the end of its path.
    pub(super) fn has_arrived(&self, pose: Pose2) -> bool {
        let left = self.way.last().map(|end| nalgebra::distance(end, &pose.position()));
        left.is_none_or(|left| left < ARRIVED)
    }

    /// The velocity over the next step of `dt` \[s\].
    pub(super) fn steer(&mut self, world: &TourWorld, pose: Pose2, dt: f64) -> Twist2 {
        let goal = self.wanted(pose);
        let toward = |now: f64, goal: f64, rate: f64| now + (goal - now).clamp(-rate, rate);
        let robot = &self.robot;
        let (change, turn) = (robot.acceleration * dt, robot.turn_acceleration * dt);
        let twist = Twist2::forward(
            toward(self.twist.vx, goal.vx, change),
            toward(self.twist.omega, goal.omega, turn),
        );
        let after = Integration::ExactArc.step(pose, twist, dt);
        let [now, then] = [pose, after].map(|pose| world.clearance(&pose.position()));
        // It brakes faster than it accelerates.
        let blocked = then < 0.8 * self.robot.radius && then <= now;
        self.twist = if blocked { Twist2::forward(0.0, goal.omega) } else { twist };
        self.twist
    }

    /// The target velocity towards the path.
    fn wanted(&mut self, pose: Pose2) -> Twist2 {
        let here = pose.position();
        let near = |point: &Point2<f64>| nalgebra::distance(point, &here) < AHEAD;
        while self.next + 1 < self.way.len() && near(&self.way[self.next]) {
            self.next += 1;
        }
        let Some(point) = self.way.get(self.next) else { return Twist2::ZERO };
        let direction = (point.y - here.y).atan2(point.x - here.x);
        let off = angle::difference(direction, pose.theta);
        let turn = self.robot.turn;
        let omega = (STEERING * off).clamp(-turn, turn);
        let straight = (1.0 - off.abs() / TURN_FIRST).max(0.0);
        Twist2::forward(self.robot.speed * straight, omega)
    }
}
