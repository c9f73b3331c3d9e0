//! People around the robot, who hide a wanted share of its beams.
//!
//! Seen from the laser, each visitor covers an interval of directions. The intervals have one
//! width and never overlap, so that together they always cover the wanted share. They drift to and
//! fro, as people do who walk along, and after a while someone leaves and another one comes on
//! another side.

use super::PeopleConfig;
use crate::source::tour::TourWorld;
use loc_core::Pose2;
use loc_core::random::ChaCha8Rng;
use loc_sensors::laser::LaserScanner;
use loc_sensors::world::{MovingObject, RangeWorld};
use nalgebra::Vector2;
use rand::RngExt;

/// How fast visitors drift around the robot at most \[rad/s\].
const DRIFT: f64 = 0.3;
/// A visitor stands before the walls: at this share of the way to the nearest one at most.
const BEFORE_WALLS: f64 = 0.7;
/// How many rays look for that wall.
const RAYS: usize = 9;
/// How often a new visitor looks for a free side.
const TRIES: usize = 50;

/// Visitors around one laser.
#[derive(Debug)]
pub(super) struct Visitors {
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
    pub(super) fn new(config: &PeopleConfig, scanner: &LaserScanner, rng: &mut ChaCha8Rng) -> Self {
        let spec = &scanner.spec;
        let (a, b) = (spec.angle_min, spec.angle_max());
        let view = (a.min(b), a.max(b));
        let covered = config.blocked_share * (view.1 - view.0);
        let wanted = config.visitor_deg.to_radians();
        let count = if covered > 0.0 { (covered / wanted).round().max(1.0) } else { 0.0 };
        // Nobody covers more than what lies before the laser.
        let half = (0.5 * covered / count.max(1.0)).min(1.2);
        let (distance, stay) = (config.distance_m, config.stay_s);
        let mounting = scanner.mounting;
        let mut visitors = Visitors { mounting, view, half, distance, stay, people: Vec::new() };
        // At most a full turn over a positive width.
        for k in 0..count as usize {
            let share = (k as f64 + 0.5) / count;
            let visitor = visitors.someone(view.0 + share * (view.1 - view.0), rng);
            visitors.people.push(visitor);
        }
        visitors
    }

    /// Everyone moves on; some leave, and others come.
    pub(super) fn step(&mut self, dt: f64, rng: &mut ChaCha8Rng) {
        for k in 0..self.people.len() {
            self.people[k].left -= dt;
            if self.people[k].left < 0.0 {
                let direction = self.free_side(k, rng);
                self.people[k] = self.someone(direction, rng);
            }
            let next = self.people[k].direction + self.people[k].drift * dt;
            if self.is_free(k, next) {
                self.people[k].direction = next;
            } else {
                self.people[k].drift *= -1.0;
            }
        }
    }

    /// Everyone as discs before the walls, for a robot at `pose`.
    pub(super) fn around<'a>(
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

    fn someone(&self, direction: f64, rng: &mut ChaCha8Rng) -> Visitor {
        let [a, b, c]: [f64; 3] = [rng.random(), rng.random(), rng.random()];
        Visitor {
            direction,
            drift: DRIFT * (2.0 * a - 1.0),
            distance: self.distance * (0.7 + 0.6 * b),
            // Exponential: those who have been here for long stay no shorter.
            left: -self.stay * (1.0 - c).ln(),
        }
    }

    /// A direction in which a visitor hides nobody else; the old one where there is none.
    fn free_side(&self, who: usize, rng: &mut ChaCha8Rng) -> f64 {
        let (low, high) = self.view;
        let mut draw = || low + rng.random::<f64>() * (high - low);
        let side = (0..TRIES).map(|_| draw()).find(|side| self.is_free(who, *side));
        side.unwrap_or(self.people[who].direction)
    }

    fn is_free(&self, who: usize, direction: f64) -> bool {
        let inside = direction - self.half >= self.view.0 && direction + self.half <= self.view.1;
        let others = self.people.iter().enumerate().filter(|(k, _)| *k != who);
        let apart = |other: &Visitor| (other.direction - direction).abs() >= 2.0 * self.half;
        inside && others.into_iter().all(|(_, other)| apart(other))
    }
}
