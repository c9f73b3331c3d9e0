//! The simulated radar.

use super::{RadarReturn, RadarSpec};
use crate::Result;
use crate::check::finite_pose;
use crate::world::{MovingObject, ObjectWorld, RangeWorld};
use loc_core::{Pose2, Twist2, angle};
use nalgebra::Vector2;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, Poisson, StandardNormal};

/// A radar on a robot.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct Radar {
    /// The radar's pose on the robot, `base_from_radar`.
    pub mounting: Pose2,
    /// Its data sheet.
    pub spec: RadarSpec,
}

impl Radar {
    /// A radar in the middle of the robot.
    ///
    /// # Errors
    /// Those of [`RadarSpec::check`].
    pub fn new(spec: RadarSpec) -> Result<Self> {
        spec.check()?;
        Ok(Radar { mounting: Pose2::IDENTITY, spec })
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a mounting that is not finite, and those of
    /// [`RadarSpec::check`].
    pub fn check(&self) -> Result<()> {
        finite_pose("mounting of a radar", self.mounting)?;
        self.spec.check()
    }

    /// The echoes of `objects` that a robot receives at `pose` while it moves with the true
    /// velocity `twist`: first those of objects, in the world's order, then false ones.
    pub fn observe<R: Rng + ?Sized>(
        &self,
        walls: &(impl RangeWorld + ?Sized),
        objects: &(impl ObjectWorld + ?Sized),
        pose: Pose2,
        twist: Twist2,
        rng: &mut R,
    ) -> Vec<RadarReturn> {
        let radar = pose * self.mounting;
        let velocity = self.velocity(pose, twist);
        let mut echoes = Vec::new();
        objects.visit_objects(&radar.position(), self.spec.range_max, &mut |object| {
            // Drawn for every object in reach, seen or not.
            let detected = rng.random::<f64>() < self.spec.noise.detection_probability;
            let error: [f64; 3] = std::array::from_fn(|_| StandardNormal.sample(rng));
            if let Some(truth) = self.view(walls, radar, velocity, &object)
                && detected
            {
                echoes.push(self.blur(truth, error));
            }
        });
        self.add_clutter(&mut echoes, rng);
        echoes
    }

    /// Velocity of the radar in the map frame \[m/s\]: away from the middle it swings in turns.
    fn velocity(&self, pose: Pose2, twist: Twist2) -> Vector2<f64> {
        let arm = self.mounting;
        let in_base = Vector2::new(twist.vx - twist.omega * arm.y, twist.vy + twist.omega * arm.x);
        pose.rotation() * in_base
    }

    /// The echo without noise; `None` out of view, or behind a wall.
    fn view(
        &self,
        walls: &(impl RangeWorld + ?Sized),
        radar: Pose2,
        velocity: Vector2<f64>,
        object: &MovingObject,
    ) -> Option<RadarReturn> {
        let way = object.position - radar.position();
        let distance = way.norm();
        let direction = way.y.atan2(way.x);
        let range = distance - object.radius;
        let bearing = angle::wrap(direction - radar.theta);
        let radial_speed = (object.velocity - velocity).dot(&way) / distance;
        let in_reach = (self.spec.range_min..=self.spec.range_max).contains(&range);
        let in_view = bearing.abs() <= 0.5 * self.spec.fov;
        let measurable = radial_speed.abs() <= self.spec.speed_max;
        let seen = in_reach && in_view && measurable;
        (seen && walls.cast(&radar.position(), direction, range).is_none()).then_some(RadarReturn {
            range,
            bearing,
            radial_speed,
        })
    }

    fn blur(&self, truth: RadarReturn, error: [f64; 3]) -> RadarReturn {
        let noise = &self.spec.noise;
        RadarReturn {
            range: (truth.range + noise.range_sigma * error[0]).max(0.0),
            bearing: angle::wrap(truth.bearing + noise.bearing_sigma * error[1]),
            radial_speed: truth.radial_speed + noise.speed_sigma * error[2],
        }
    }

    fn add_clutter<R: Rng + ?Sized>(&self, echoes: &mut Vec<RadarReturn>, rng: &mut R) {
        let spec = &self.spec;
        // A mean of 0 is no Poisson distribution, and no clutter.
        let Ok(count) = Poisson::new(spec.noise.clutter) else { return };
        let count: f64 = count.sample(rng);
        for _ in 0..count as usize {
            let mut share = || rng.random::<f64>();
            echoes.push(RadarReturn {
                range: spec.range_min + share() * (spec.range_max - spec.range_min),
                bearing: (share() - 0.5) * spec.fov,
                radial_speed: (2.0 * share() - 1.0) * spec.speed_max,
            });
        }
    }
}
