//! How a robot follows a way: it steers towards a point a little ahead on it (pure pursuit,
//! Coulter 1992), slows down in turns, and turns on the spot where the way leads elsewhere.

use super::world::TourWorld;
use loc_core::error::positive;
use loc_core::motion::Integration;
use loc_core::{Pose2, Twist2, angle};
use nalgebra::Point2;
use serde::Deserialize;

/// How far ahead the robot looks \[m\].
const AHEAD: f64 = 0.45;
/// A way ends this far from its last point \[m\].
const ARRIVED: f64 = 0.15;
/// Where the way turns off by more than this, the robot turns on the spot \[rad\].
const TURN_FIRST: f64 = 0.9;
/// Turn rate for each radian that the robot looks past its point \[1/s\].
const STEERING: f64 = 2.5;

/// What the robot can do.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RobotConfig {
    /// The robot keeps this far from walls.
    pub radius_m: f64,
    /// Speed where nothing is in the way.
    pub speed_m_s: f64,
    /// Largest turn rate.
    pub turn_deg_s: f64,
    /// Change of the speed.
    pub acceleration_m_s2: f64,
    /// Change of the turn rate.
    pub turn_acceleration_deg_s2: f64,
}

impl Default for RobotConfig {
    /// A small service robot.
    fn default() -> Self {
        RobotConfig {
            radius_m: 0.3,
            speed_m_s: 0.7,
            turn_deg_s: 70.0,
            acceleration_m_s2: 0.8,
            turn_acceleration_deg_s2: 200.0,
        }
    }
}

impl RobotConfig {
    /// Checks every value.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] with the key.
    pub(super) fn check(&self) -> crate::Result<()> {
        positive("tour.robot.radius_m", self.radius_m)?;
        positive("tour.robot.speed_m_s", self.speed_m_s)?;
        positive("tour.robot.turn_deg_s", self.turn_deg_s)?;
        positive("tour.robot.acceleration_m_s2", self.acceleration_m_s2)?;
        positive("tour.robot.turn_acceleration_deg_s2", self.turn_acceleration_deg_s2)?;
        Ok(())
    }
}

/// A robot on its way.
#[derive(Debug)]
pub(super) struct Driver {
    robot: RobotConfig,
    way: Vec<Point2<f64>>,
    /// The point that the robot steers to.
    next: usize,
    twist: Twist2,
}

impl Driver {
    /// A robot that stands still.
    pub(super) fn new(robot: RobotConfig) -> Self {
        Driver { robot, way: Vec::new(), next: 0, twist: Twist2::ZERO }
    }

    /// Sends the robot on a way.
    pub(super) fn follow(&mut self, way: Vec<Point2<f64>>) {
        (self.way, self.next) = (way, 0);
    }

    /// Stops at once: the robot has been lifted.
    pub(super) fn stop(&mut self) {
        self.follow(Vec::new());
        self.twist = Twist2::ZERO;
    }

    /// Whether a robot at `pose` is at the end of its way.
    pub(super) fn has_arrived(&self, pose: Pose2) -> bool {
        let left = self.way.last().map(|end| nalgebra::distance(end, &pose.position()));
        left.is_none_or(|left| left < ARRIVED)
    }

    /// The velocity over the next step of `dt` \[s\].
    pub(super) fn steer(&mut self, world: &TourWorld, pose: Pose2, dt: f64) -> Twist2 {
        let goal = self.wanted(pose);
        let toward = |now: f64, goal: f64, rate: f64| now + (goal - now).clamp(-rate, rate);
        let robot = &self.robot;
        let (change, turn) =
            (robot.acceleration_m_s2 * dt, robot.turn_acceleration_deg_s2.to_radians() * dt);
        let twist = Twist2::forward(
            toward(self.twist.vx, goal.vx, change),
            toward(self.twist.omega, goal.omega, turn),
        );
        let after = Integration::ExactArc.step(pose, twist, dt);
        let [now, then] = [pose, after].map(|pose| world.clearance(&pose.position()));
        // The brakes are better than the motors.
        let blocked = then < 0.8 * self.robot.radius_m && then <= now;
        self.twist = if blocked { Twist2::forward(0.0, goal.omega) } else { twist };
        self.twist
    }

    /// The velocity that leads to the way.
    fn wanted(&mut self, pose: Pose2) -> Twist2 {
        let here = pose.position();
        let near = |point: &Point2<f64>| nalgebra::distance(point, &here) < AHEAD;
        while self.next + 1 < self.way.len() && near(&self.way[self.next]) {
            self.next += 1;
        }
        let Some(point) = self.way.get(self.next) else { return Twist2::ZERO };
        let direction = (point.y - here.y).atan2(point.x - here.x);
        let off = angle::difference(direction, pose.theta);
        let turn = self.robot.turn_deg_s.to_radians();
        let omega = (STEERING * off).clamp(-turn, turn);
        let straight = (1.0 - off.abs() / TURN_FIRST).max(0.0);
        Twist2::forward(self.robot.speed_m_s * straight, omega)
    }
}
