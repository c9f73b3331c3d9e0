//! People who go about the building: straight on, until something is in the way.

use super::PeopleConfig;
use crate::source::tour::TourWorld;
use loc_core::Pose2;
use loc_core::random::ChaCha8Rng;
use loc_maps::grid::Occupancy;
use loc_sensors::world::MovingObject;
use nalgebra::{Point2, Vector2};
use rand::RngExt;
use std::f64::consts::TAU;

/// Someone this near to the laser's middle gives way to the robot \[m\].
const GIVES_WAY: f64 = 0.4;
/// How often a walker looks for a free direction in one step.
const TRIES: usize = 8;

/// Walkers of one speed.
#[derive(Debug)]
pub(super) struct Walkers {
    speed: f64,
    people: Vec<MovingObject>,
}

impl Walkers {
    /// Walkers at free places, each with a direction.
    pub(super) fn new(config: &PeopleConfig, world: &TourWorld, rng: &mut ChaCha8Rng) -> Self {
        let radius = config.radius_m;
        let free = world.grid().centers_of(Occupancy::Free);
        let places: Vec<Point2<f64>> =
            free.filter(|place| world.clearance(place) > radius).collect();
        let mut people = Vec::new();
        if !places.is_empty() {
            people.extend((0..config.count).map(|_| MovingObject {
                position: places[rng.random_range(0..places.len())],
                velocity: velocity(config.speed_m_s, rng),
                radius,
            }));
        }
        Walkers { speed: config.speed_m_s, people }
    }

    /// Everyone goes on; who would run into a wall turns to where there is none.
    pub(super) fn step(&mut self, world: &TourWorld, dt: f64, rng: &mut ChaCha8Rng) {
        for person in &mut self.people {
            for _ in 0..TRIES {
                let next = person.position + person.velocity * dt;
                if world.clearance(&next) > person.radius {
                    person.position = next;
                    break;
                }
                person.velocity = velocity(self.speed, rng);
            }
        }
    }

    /// Those who do not stand where the robot is.
    pub(super) fn away_from(&self, robot: Pose2) -> impl Iterator<Item = MovingObject> + '_ {
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
