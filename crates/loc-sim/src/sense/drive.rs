//! A short drive through the free space of any map, for sensors that feel motion.
//!
//! The robot looks ahead along a fan of arcs and takes the one that keeps it in free space longest
//! and farthest from walls (the dynamic window of Fox, Burgard and Thrun 1997, with a single speed).
//! It draws no random numbers: one map and one start give one drive.

use super::{Place, Station};
use crate::Result;
use crate::config::field;
use loc_core::error::positive;
use loc_core::motion::Integration;
use loc_core::{Pose2, Twist2};
use loc_plot::{Chart, Role, Style};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How long and how fast to drive.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DriveSettings {
    /// Duration \[s\].
    pub(super) duration: f64,
    /// Speed where nothing is in the way \[m/s\].
    pub(super) speed: f64,
    /// Time from one reading to the next \[s\].
    pub(super) time_step: f64,
}

/// The true motion over one time step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    /// Time at its end \[s\].
    pub(super) time: f64,
    /// Pose at its end.
    pub(super) pose: Pose2,
    /// Velocity, constant over the step.
    pub(super) twist: Twist2,
    /// How the velocity changes per second.
    pub(super) change: Twist2,
}

/// A drive, step by step.
pub(super) struct Drive {
    /// Where it starts.
    pub(super) start: Pose2,
    /// Its time steps.
    pub(super) steps: Vec<Step>,
}

impl Drive {
    /// A number over time, of the index of a step and the step.
    pub(super) fn over_time(&self, of: impl Fn(usize, &Step) -> f64) -> Vec<(f64, f64)> {
        self.steps.iter().enumerate().map(|(k, step)| (step.time, of(k, step))).collect()
    }

    /// The true path.
    pub(super) fn path(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.steps.iter().map(|step| (step.pose.x, step.pose.y))
    }

    /// The pose at the end.
    pub(super) fn end(&self) -> Pose2 {
        self.steps.last().map_or(self.start, |step| step.pose)
    }

    /// The drive over the map.
    pub(super) fn draw(&self, station: &Station, title: &str) -> String {
        let scene = station.scene(title, "").path(Role::Method(0), "true path", self.path());
        scene.poses(Role::Truth, "start", [self.start]).render()
    }

    /// A chart of what is measured in the first style, over the truth in the second one.
    pub(super) fn compared(
        &self,
        name: &str,
        label: &str,
        [measured, truth]: [Style; 2],
        measurement: impl Fn(usize, &Step) -> f64,
        true_value: impl Fn(usize, &Step) -> f64,
    ) -> Chart {
        Chart::new(name).line(measured, label, self.over_time(measurement)).line(
            truth,
            "truth",
            self.over_time(true_value),
        )
    }
}

/// The usual styles of a measurement and of the truth.
pub(super) fn dotted_truth() -> [Style; 2] {
    [Role::Method(1).into(), Role::Truth.dotted()]
}

const MAX_STEPS: f64 = 1e6;
/// The robot stands for this long before it starts \[s\].
const STAND: f64 = 2.0;
/// How far it looks ahead, and in what steps \[s\].
const HORIZON: f64 = 3.0;
const LOOK_STEP: f64 = 0.2;
/// Largest turn rate \[rad/s\], and accelerations \[m/s^2, rad/s^2\].
const TURN: f64 = 1.0;
const ACCELERATION: f64 = 0.8;
const TURN_ACCELERATION: f64 = 2.5;
/// How long its velocity lags behind \[s\].
const LAG: f64 = 0.3;

impl DriveSettings {
    pub(super) fn new(duration: f64, time_step: f64) -> Self {
        DriveSettings { duration, speed: 0.8, time_step }
    }

    /// Drives from a start.
    pub(super) fn drive(&self, place: &Place, start: Pose2) -> Result<Drive> {
        positive("drive.duration [s]", self.duration)?;
        positive("drive.speed [m/s]", self.speed)?;
        positive("drive.time_step [s]", self.time_step)?;
        let steps = (self.duration / self.time_step).round();
        if !(1.0..=MAX_STEPS).contains(&steps) {
            let expected = "a duration of 1 to 1000000 time steps";
            return Err(field("drive.duration", expected, &self.duration.to_string()));
        }
        let body = (0.6 * place.clearance(&start.position())).min(0.35);
        let visits = BTreeMap::new();
        let mut driver = Driver { place, body, speed: self.speed, turning: 1.0, visits };
        let (mut pose, mut twist, mut steps_driven) = (start, Twist2::ZERO, Vec::new());
        let (mut goal, mut decided) = (Twist2::ZERO, f64::NEG_INFINITY);
        // Checked to be a whole number up to 1e6.
        for k in 1..=steps as usize {
            let time = k as f64 * self.time_step;
            if time > STAND && time - decided >= 0.1 {
                (goal, decided) = (driver.decide(pose, twist), time);
            }
            let next = self.approach(twist, goal);
            let mean =
                Twist2::forward(0.5 * (twist.vx + next.vx), 0.5 * (twist.omega + next.omega));
            let per_second = |from: f64, to: f64| (to - from) / self.time_step;
            let change =
                Twist2::forward(per_second(twist.vx, next.vx), per_second(twist.omega, next.omega));
            pose = Integration::ExactArc.step(pose, mean, self.time_step);
            twist = next;
            steps_driven.push(Step { time, pose, twist: mean, change });
        }
        Ok(Drive { start, steps: steps_driven })
    }

    /// The velocity after a step: it follows the goal smoothly, within the accelerations.
    fn approach(&self, now: Twist2, goal: Twist2) -> Twist2 {
        let toward = |now: f64, goal: f64, rate: f64| {
            let wanted = (goal - now) / LAG.max(self.time_step);
            now + wanted.clamp(-rate, rate) * self.time_step
        };
        Twist2::forward(
            toward(now.vx, goal.vx, ACCELERATION),
            toward(now.omega, goal.omega, TURN_ACCELERATION),
        )
    }
}

struct Driver<'a> {
    place: &'a Place,
    body: f64,
    speed: f64,
    /// The side it turns to where nothing else works.
    turning: f64,
    /// How often it has been where, by squares of half a metre.
    visits: BTreeMap<(i64, i64), f64>,
}

impl Driver<'_> {
    fn decide(&mut self, pose: Pose2, now: Twist2) -> Twist2 {
        *self.visits.entry(square(pose)).or_default() += 1.0;
        let arcs = (-10..=10).map(|k| f64::from(k) / 10.0 * TURN);
        let rated = arcs.map(|omega| {
            let (free, room, known) = self.look_ahead(pose, omega);
            let smooth = 0.12 * omega.abs() + 0.25 * (omega - now.omega).abs();
            (2.0 * free + room.min(0.5) - smooth - known, free, omega)
        });
        let best = rated.reduce(|best, next| if next.0 > best.0 { next } else { best });
        let Some((_, free, omega)) = best.filter(|(_, free, _)| *free > 0.25) else {
            return Twist2::forward(0.0, self.turning * TURN);
        };
        if omega.abs() > 0.3 {
            self.turning = omega.signum();
        }
        // Slower in turns and before walls.
        let share = (1.2 * free - 0.1).min(1.0 - 0.5 * omega.abs() / TURN);
        Twist2::forward(self.speed * share.clamp(0.15, 1.0), omega)
    }

    /// The share of the horizon that an arc stays in free space, its smallest clearance \[m\], and
    /// how well the robot knows the places along it: it looks for new ones.
    fn look_ahead(&self, pose: Pose2, omega: f64) -> (f64, f64, f64) {
        let steps = (HORIZON / LOOK_STEP).round() as usize;
        let (mut at, mut room, mut known) = (pose, f64::INFINITY, 0.0);
        for k in 0..steps {
            at = Integration::ExactArc.step(at, Twist2::forward(self.speed, omega), LOOK_STEP);
            let clearance = self.place.clearance(&at.position());
            if clearance < self.body {
                return (k as f64 / steps as f64, 0.0, known);
            }
            room = room.min(clearance);
            let visits = self.visits.get(&square(at)).copied().unwrap_or(0.0);
            known += 0.9 / steps as f64 * (visits / 15.0).min(4.0);
        }
        (1.0, room, known)
    }
}

fn square(pose: Pose2) -> (i64, i64) {
    // The casts saturate.
    ((2.0 * pose.x).floor() as i64, (2.0 * pose.y).floor() as i64)
}
