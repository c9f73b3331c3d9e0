//! People in the way of the beams (K3).
//!
//! A map shows walls; a museum is full of visitors. They stand before the laser for several scans,
//! in clusters of neighbouring beams: what one beam says of the next is not independent, and the
//! past matters for the future. This breaks the assumption that localization rests on, so methods
//! have to look at readings twice.
//!
//! Two kinds of people are simulated, both as discs. Walkers go about the building. Visitors
//! surround the robot, wherever it goes, and hide a wanted share of its beams.

mod config;
mod crowded;
mod visitors;
mod walkers;

pub use config::PeopleConfig;
pub use crowded::Crowded;

use super::tour::TourWorld;
use loc_core::Pose2;
use loc_core::random::ChaCha8Rng;
use loc_sensors::laser::LaserScanner;
use loc_sensors::world::MovingObject;
use visitors::Visitors;
use walkers::Walkers;

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

    /// Moves everyone on by `dt` \[s\]; the robot is at `pose` by then.
    pub fn step(&mut self, world: &TourWorld, pose: Pose2, dt: f64) {
        self.walkers.step(world, dt, &mut self.rng);
        self.visitors.step(dt, &mut self.rng);
        self.gather(world, pose);
    }

    /// Where everyone is.
    pub fn people(&self) -> &[MovingObject] {
        &self.people
    }

    /// A world with these people in it.
    pub fn before<W>(&self, walls: W) -> Crowded<'_, W> {
        Crowded { walls, people: &self.people }
    }

    fn gather(&mut self, world: &TourWorld, pose: Pose2) {
        self.people.clear();
        self.people.extend(self.walkers.away_from(pose));
        self.people.extend(self.visitors.around(world, pose));
    }
}
