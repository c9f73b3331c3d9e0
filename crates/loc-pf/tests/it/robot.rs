//! A robot that wanders through a simulated building, for the tests.

use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Pose2, angle};
use loc_maps::worlds::{self, WorldSettings};
use loc_maps::{DistanceMap, OccupancyGrid, RayCaster};
use loc_sensors::laser::{LaserScan, LaserScanner, LaserSpec};
use nalgebra::Point2;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};

/// An office of 30 m x 20 m.
pub(crate) fn office(seed: u64) -> OccupancyGrid {
    let settings = WorldSettings { width: 600, height: 400, resolution: 0.05, seed };
    worlds::office(&settings).unwrap().grid
}

/// A robot with a laser, at its true pose and at the one its odometry believes in.
pub(crate) struct Robot {
    pub(crate) truth: Pose2,
    pub(crate) odometry: Pose2,
    walls: RayCaster,
    clearance: DistanceMap,
    laser: LaserScanner,
    rng: ChaCha8Rng,
    turning: f64,
}

impl Robot {
    /// A robot at a random clear place of a map.
    pub(crate) fn new(map: &OccupancyGrid, laser: LaserScanner, seed: u64) -> Self {
        let clearance = DistanceMap::new(map, 2.0).unwrap();
        let mut robot = Robot {
            truth: Pose2::IDENTITY,
            odometry: Pose2::IDENTITY,
            walls: RayCaster::new(map),
            clearance,
            laser,
            rng: stream(seed, "robot"),
            turning: 1.0,
        };
        robot.carry_off();
        robot
    }

    /// A laser of 270 degrees with 30 m reach, 2 cm noise, and every fourth beam of a LMS100.
    pub(crate) fn laser() -> LaserScanner {
        let spec = LaserSpec { beams: 271, ..LaserSpec::sick_lms100() };
        let noise = loc_sensors::laser::LaserNoise { sigma: 0.02, sigma_per_m: 0.0 };
        let step = 1_f64.to_radians();
        let start = -135.0 * step;
        LaserScanner::new(LaserSpec { angle_min: start, angle_increment: step, noise, ..spec })
            .unwrap()
    }

    fn distance(&self, pose: Pose2) -> f64 {
        self.clearance.distance_at(&pose.position()).unwrap_or(0.0)
    }

    /// Puts the robot at a random clear place; its odometry learns nothing of that.
    pub(crate) fn carry_off(&mut self) {
        let frame = *self.clearance.frame();
        loop {
            let [u, v]: [f64; 2] = [self.rng.random(), self.rng.random()];
            let Point2 { coords } =
                frame.to_map(u * frame.width() as f64, v * frame.height() as f64);
            let theta = angle::wrap(self.rng.random::<f64>() * std::f64::consts::TAU);
            self.truth = Pose2::new(coords.x, coords.y, theta);
            if self.walls_around() {
                return;
            }
        }
    }

    fn walls_around(&self) -> bool {
        self.distance(self.truth) > 0.4
    }

    /// Drives about 0.2 m, or turns where there is no room; the odometry is off by 5 % and 3 %.
    pub(crate) fn drive(&mut self) {
        let ahead = self.truth * Pose2::new(0.45, 0.0, 0.0);
        let step = if self.distance(ahead) > 0.35 {
            let bend: f64 = StandardNormal.sample(&mut self.rng);
            self.turning = if bend > 0.0 { 1.0 } else { -1.0 };
            Pose2::new(0.2, 0.0, 0.1 * bend)
        } else {
            Pose2::new(0.0, 0.0, 0.3 * self.turning)
        };
        self.truth = self.truth * step;
        let mut off = |sigma: f64| {
            let z: f64 = StandardNormal.sample(&mut self.rng);
            sigma * z
        };
        let (along, heading) = (off(0.02 * step.x.sqrt()), off(0.03 * step.theta.abs().sqrt()));
        let drift = off(0.03 * step.x.sqrt());
        let reported = Pose2::new(step.x + along, 0.0, step.theta + heading + drift);
        self.odometry = self.odometry * reported;
    }

    pub(crate) fn scan(&mut self) -> LaserScan {
        self.laser.scan(&self.walls, self.truth, &mut self.rng)
    }

    /// Distance \[m\] and turn \[rad\] from the true pose.
    pub(crate) fn error(&self, pose: Pose2) -> (f64, f64) {
        (pose.distance(self.truth), angle::difference(pose.theta, self.truth.theta).abs())
    }
}
