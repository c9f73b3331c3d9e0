//! A robot that wanders through a simulated office, for the tests.

use loc_core::Pose2;
use loc_core::random::{ChaCha8Rng, stream};
use loc_maps::worlds::{self, WorldSettings};
use loc_maps::{DistanceMap, OccupancyGrid};
use loc_sensors::laser::{LaserScan, LaserScanner, LaserSpec};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};

/// An office of 15 m x 12 m.
pub(super) fn office() -> OccupancyGrid {
    let settings = WorldSettings { width: 300, height: 240, resolution: 0.05, seed: 3 };
    worlds::office(&settings).unwrap().grid
}

/// A robot with a laser, at its true pose and at the one that its odometry believes in.
pub(super) struct Robot<'a> {
    pub(super) truth: Pose2,
    pub(super) odometry: Pose2,
    map: &'a OccupancyGrid,
    clearance: DistanceMap,
    laser: LaserScanner,
    rng: ChaCha8Rng,
}

impl<'a> Robot<'a> {
    /// A robot at a random clear place.
    pub(super) fn new(map: &'a OccupancyGrid, seed: u64) -> Self {
        let mut robot = Robot {
            truth: Pose2::IDENTITY,
            odometry: Pose2::new(70.0, -20.0, 1.0),
            map,
            clearance: DistanceMap::new(map, 2.0).unwrap(),
            laser: LaserScanner::new(LaserSpec::sick_lms100()).unwrap(),
            rng: stream(seed, "robot"),
        };
        robot.carry_off();
        robot
    }

    /// Puts the robot at a random clear place at least 3 m away; odometry learns nothing of it.
    pub(super) fn carry_off(&mut self) {
        let before = self.truth;
        loop {
            let (u, v) = (self.rng.random_range(0.0..300.0), self.rng.random_range(0.0..240.0));
            let at = self.map.frame().to_map(u, v);
            self.truth = Pose2::new(at.x, at.y, self.rng.random_range(-3.1..3.1));
            let is_free = self.map.value_at(&at) == Some(0);
            if is_free && self.room(self.truth) > 0.4 && self.truth.distance(before) > 3.0 {
                return;
            }
        }
    }

    fn room(&self, pose: Pose2) -> f64 {
        self.clearance.distance_at(&pose.position()).unwrap_or(0.0)
    }

    /// Drives on by 0.3 m, or turns where there is no way.
    pub(super) fn drive(&mut self) {
        let ahead = Pose2::new(0.3, 0.0, 0.05);
        let free = self.room(self.truth * ahead) > 0.35;
        let step = if free { ahead } else { Pose2::new(0.0, 0.0, 0.6) };
        let mut noise = |sigma: f64| {
            let z: f64 = StandardNormal.sample(&mut self.rng);
            sigma * z
        };
        let wrong = Pose2::new(noise(0.02), noise(0.01), noise(0.02));
        self.truth = self.truth * step;
        self.odometry = self.odometry * step * wrong;
    }

    pub(super) fn scan(&mut self) -> LaserScan {
        self.laser.scan(self.map, self.truth, &mut self.rng)
    }
}
