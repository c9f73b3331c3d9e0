//! People in the way of the beams (K3).
//!
//! A map shows walls; a museum is full of visitors. They block neighbouring beams for several
//! scans, so the errors of beams and scans are not independent. This violates the Markov
//! assumption of localization: methods have to filter the ranges.
//!
//! Two kinds of people are simulated, both as discs. Walkers cross the building. Visitors surround
//! the robot wherever it drives and hide a given share of its beams.

use super::tour::TourWorld;
use crate::Result;
use crate::config::field;
use loc_core::error::{non_negative, positive};
use loc_core::random::ChaCha8Rng;
use loc_core::{Pose2, angle};
use loc_maps::grid::Occupancy;
use loc_sensors::laser::LaserScanner;
use loc_sensors::world::{MovingObject, Pane, RangeWorld};
use nalgebra::{Point2, Vector2};
use rand::RngExt;
use serde::Deserialize;
use std::f64::consts::TAU;

/// All people of a building.
#[derive(Debug)]
pub struct Crowd {
    walkers: Walkers,
    visitors: Visitors,
    people: Vec<MovingObject>,
    rng: ChaCha8Rng,
}

impl Crowd {
    /// People as configured, around a robot at `pose` with this laser.
    pub fn new(
        config: &PeopleConfig,
        world: &TourWorld,
        scanner: &LaserScanner,
        pose: Pose2,
        mut rng: ChaCha8Rng,
    ) -> Self {
        let walkers = Walkers::new(config, world, &mut rng);
        let visitors = Visitors::new(config, scanner, &mut rng);
        let mut crowd = Crowd { walkers, visitors, people: Vec::new(), rng };
        crowd.gather(world, pose);
        crowd
    }

    /// Moves all people for `dt` \[s\]; the robot is at `pose` afterwards.
    pub fn step(&mut self, world: &TourWorld, pose: Pose2, dt: f64) {
        self.walkers.step(world, dt, &mut self.rng);
        self.visitors.step(dt, &mut self.rng);
        self.gather(world, pose);
    }

    /// The people as discs.
    pub fn people(&self) -> &[MovingObject] {
        &self.people
    }

    /// A world with these people in front of its walls.
    pub fn with_people<W>(&self, walls: W) -> Crowded<'_, W> {
        Crowded { walls, people: &self.people }
    }

    fn gather(&mut self, world: &TourWorld, pose: Pose2) {
        self.people.clear();
        self.people.extend(self.walkers.away_from(pose));
        self.people.extend(self.visitors.around(world, pose));
    }
}

/// Number and behaviour of the people in a building.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PeopleConfig {
    /// Number of walkers in the building.
    pub count: usize,
    /// Radius of a walker, as the laser sees it \[m\].
    pub radius: f64,
    /// Speed of the walkers \[m/s\].
    pub speed: f64,
    /// Share of the beams that visitors around the robot hide, in \[0, 0.9\].
    pub blocked_share: f64,
    /// Angle that a visitor covers, seen from the laser; adapted so that a whole number of them
    /// covers the share \[rad\].
    #[serde(with = "loc_core::settings::angle")]
    pub visitor: f64,
    /// Distance of the visitors from the laser \[m\].
    pub distance: f64,
    /// Mean time that a visitor stays \[s\].
    pub stay: f64,
}

impl Default for PeopleConfig {
    /// No people; common sizes for those that are added.
    fn default() -> Self {
        PeopleConfig {
            count: 0,
            radius: 0.25,
            speed: 1.0,
            blocked_share: 0.0,
            visitor: 25_f64.to_radians(),
            distance: 1.0,
            stay: 4.0,
        }
    }
}

impl PeopleConfig {
    /// Largest number of walkers.
    const MAX: usize = 10_000;

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::Config`] and [`loc_core::Error::OutOfRange`] with the key.
    pub fn check(&self) -> Result<()> {
        if self.count > Self::MAX {
            return Err(field("tour.people.count", "at most 10000", &self.count.to_string()));
        }
        positive("tour.people.radius", self.radius)?;
        non_negative("tour.people.speed", self.speed)?;
        if !(0.0..=0.9).contains(&self.blocked_share) {
            let found = self.blocked_share.to_string();
            return Err(field("tour.people.blocked_share", "a share from 0 to 0.9", &found));
        }
        positive("tour.people.visitor", self.visitor)?;
        positive("tour.people.distance", self.distance)?;
        positive("tour.people.stay", self.stay)?;
        Ok(())
    }
}

/// Walkers nearer to the robot than this, plus their radius, are left out \[m\].
const GIVES_WAY: f64 = 0.4;
/// Attempts of a walker to find a free direction in one step.
const WALKER_TRIES: usize = 8;

/// People who walk through the building in straight lines, all at one speed, until a wall is in the
/// way.
#[derive(Debug)]
struct Walkers {
    speed: f64,
    people: Vec<MovingObject>,
}

impl Walkers {
    /// Walkers at free places, each with a direction.
    fn new(config: &PeopleConfig, world: &TourWorld, rng: &mut ChaCha8Rng) -> Self {
        let radius = config.radius;
        let free = world.grid().centers_of(Occupancy::Free);
        let places: Vec<Point2<f64>> =
            free.filter(|place| world.clearance(place) > radius).collect();
        let mut people = Vec::new();
        if !places.is_empty() {
            people.extend((0..config.count).map(|_| MovingObject {
                position: places[rng.random_range(0..places.len())],
                velocity: velocity(config.speed, rng),
                radius,
            }));
        }
        Walkers { speed: config.speed, people }
    }

    /// Moves every walker; one that would run into a wall turns to a free direction.
    fn step(&mut self, world: &TourWorld, dt: f64, rng: &mut ChaCha8Rng) {
        for person in &mut self.people {
            for _ in 0..WALKER_TRIES {
                let next = person.position + person.velocity * dt;
                if world.clearance(&next) > person.radius {
                    person.position = next;
                    break;
                }
                person.velocity = velocity(self.speed, rng);
            }
        }
    }

    /// The walkers that are not at the robot's position.
    fn away_from(&self, robot: Pose2) -> impl Iterator<Item = MovingObject> + '_ {
        let near = move |person: &MovingObject| {
            nalgebra::distance(&person.position, &robot.position()) < GIVES_WAY + person.radius
        };
        self.people.iter().copied().filter(move |person| !near(person))
    }
}

fn velocity(speed: f64, rng: &mut ChaCha8Rng) -> Vector2<f64> {
    let (sin, cos) = (TAU * rng.random::<f64>()).sin_cos();
    Vector2::new(speed * cos, speed * sin)
}

/// Largest drift of a visitor around the robot \[rad/s\].
const DRIFT: f64 = 0.3;
/// Largest distance of a visitor, as a share of the distance to the nearest wall.
const BEFORE_WALLS: f64 = 0.7;
/// Number of rays that measure the distance to that wall.
const RAYS: usize = 9;
/// Attempts to place a new visitor at a free direction.
const VISITOR_TRIES: usize = 50;

/// People around the robot who hide a given share of the beams of its laser.
///
/// Seen from the laser, each visitor covers an interval of directions. The intervals have one
/// width and never overlap, so that together they always cover that share. They drift to and fro,
/// and after a while a visitor leaves and another one takes another direction.
#[derive(Debug)]
struct Visitors {
    mounting: Pose2,
    /// First and last direction of the laser's beams \[rad\].
    view: (f64, f64),
    /// Half of the angle that each of them covers \[rad\].
    half: f64,
    distance: f64,
    stay: f64,
    people: Vec<Visitor>,
}

#[derive(Debug, Clone, Copy)]
struct Visitor {
    /// Direction of the middle, from the laser \[rad\].
    direction: f64,
    drift: f64,
    /// Distance from the laser \[m\].
    distance: f64,
    /// Time until they leave \[s\].
    left: f64,
}

impl Visitors {
    fn new(config: &PeopleConfig, scanner: &LaserScanner, rng: &mut ChaCha8Rng) -> Self {
        let spec = &scanner.spec;
        let (a, b) = (spec.angle_min, spec.angle_max());
        let view = (a.min(b), a.max(b));
        let covered = config.blocked_share * (view.1 - view.0);
        let wanted = config.visitor;
        let count = if covered > 0.0 { (covered / wanted).round().max(1.0) } else { 0.0 };
        // A disc covers less than half a turn.
        let half = (0.5 * covered / count.max(1.0)).min(1.2);
        let (distance, stay) = (config.distance, config.stay);
        let mounting = scanner.mounting;
        let mut visitors = Visitors { mounting, view, half, distance, stay, people: Vec::new() };
        // At most a full turn over a positive width.
        for k in 0..count as usize {
            let share = (k as f64 + 0.5) / count;
            let visitor = visitors.visitor(view.0 + share * (view.1 - view.0), rng);
            visitors.people.push(visitor);
        }
        visitors
    }

    /// Moves every visitor; some leave and are replaced.
    fn step(&mut self, dt: f64, rng: &mut ChaCha8Rng) {
        for k in 0..self.people.len() {
            self.people[k].left -= dt;
            if self.people[k].left < 0.0 {
                let direction = self.free_direction(k, rng);
                self.people[k] = self.visitor(direction, rng);
            }
            let next = self.people[k].direction + self.people[k].drift * dt;
            if self.is_free(k, next) {
                self.people[k].direction = next;
            } else {
                self.people[k].drift *= -1.0;
            }
        }
    }

    /// The visitors as discs in front of the walls, for a robot at `pose`.
    fn around<'a>(
        &'a self,
        world: &'a TourWorld,
        pose: Pose2,
    ) -> impl Iterator<Item = MovingObject> + 'a {
        let laser = pose * self.mounting;
        self.people.iter().map(move |visitor| {
            let direction = laser.theta + visitor.direction;
            let across = (0..RAYS).map(|k| 2.0 * k as f64 / (RAYS - 1) as f64 - 1.0);
            let ranges = across.map(|share| {
                let ray = direction + share * self.half;
                world.walls().cast(&laser.position(), ray, 10.0).unwrap_or(10.0)
            });
            let wall = ranges.fold(f64::INFINITY, f64::min);
            let distance = visitor.distance.min(BEFORE_WALLS * wall);
            let (sin, cos) = direction.sin_cos();
            MovingObject {
                position: laser.position() + Vector2::new(distance * cos, distance * sin),
                velocity: Vector2::zeros(),
                radius: distance * self.half.sin(),
            }
        })
    }

    fn visitor(&self, direction: f64, rng: &mut ChaCha8Rng) -> Visitor {
        let [a, b, c]: [f64; 3] = [rng.random(), rng.random(), rng.random()];
        Visitor {
            direction,
            drift: DRIFT * (2.0 * a - 1.0),
            distance: self.distance * (0.7 + 0.6 * b),
            // Exponential: memoryless.
            left: -self.stay * (1.0 - c).ln(),
        }
    }

    /// A direction in which a visitor hides no other one; the old one where there is none.
    fn free_direction(&self, who: usize, rng: &mut ChaCha8Rng) -> f64 {
        let (low, high) = self.view;
        let mut draw = || low + rng.random::<f64>() * (high - low);
        let side = (0..VISITOR_TRIES).map(|_| draw()).find(|side| self.is_free(who, *side));
        side.unwrap_or(self.people[who].direction)
    }

    fn is_free(&self, who: usize, direction: f64) -> bool {
        let inside = direction - self.half >= self.view.0 && direction + self.half <= self.view.1;
        let others = self.people.iter().enumerate().filter(|(k, _)| *k != who);
        let apart = |other: &Visitor| (other.direction - direction).abs() >= 2.0 * self.half;
        inside && others.into_iter().all(|(_, other)| apart(other))
    }
}

/// A world of walls with people, as discs, in front of them. A person who covers the laser itself
/// is not seen.
#[derive(Debug, Clone, Copy)]
pub struct Crowded<'a, W> {
    walls: W,
    people: &'a [MovingObject],
}

impl<W: RangeWorld> RangeWorld for Crowded<'_, W> {
    fn cast(&self, origin: &Point2<f64>, direction: f64, max_range: f64) -> Option<f64> {
        let (sin, cos) = direction.sin_cos();
        let wall = self.walls.cast(origin, direction, max_range).unwrap_or(f64::INFINITY);
        let people = self.people.iter();
        let hits = people.filter_map(|person| distance(person, origin, &Vector2::new(cos, sin)));
        let range = hits.fold(wall, f64::min);
        (range <= max_range).then_some(range)
    }

    fn cast_fan(
        &self,
        origin: &Point2<f64>,
        first: f64,
        increment: f64,
        max_range: f64,
        ranges: &mut [f64],
    ) {
        self.walls.cast_fan(origin, first, increment, max_range, ranges);
        for person in self.people {
            let to_person = person.position - origin;
            let far = to_person.norm();
            if far <= person.radius || far - person.radius > max_range {
                continue;
            }
            let middle = to_person.y.atan2(to_person.x);
            let half = (person.radius / far).asin() + increment.abs();
            for (k, range) in ranges.iter_mut().enumerate() {
                let direction = first + k as f64 * increment;
                if angle::difference(direction, middle).abs() > half {
                    continue;
                }
                let (sin, cos) = direction.sin_cos();
                let hit = distance(person, origin, &Vector2::new(cos, sin));
                *range = hit.filter(|hit| *hit <= max_range).map_or(*range, |hit| hit.min(*range));
            }
        }
    }

    fn panes(&self) -> &[Pane] {
        self.walls.panes()
    }
}

/// Distance along a unit vector to a person; `None` where the ray misses.
fn distance(person: &MovingObject, origin: &Point2<f64>, along: &Vector2<f64>) -> Option<f64> {
    let to_person = person.position - origin;
    let nearest = to_person.dot(along);
    let past = to_person.norm_squared() - nearest * nearest;
    let square = person.radius * person.radius - past;
    let range = nearest - square.sqrt();
    // NaN for a ray that misses is not above 0 either.
    (range > 0.0).then_some(range)
}
