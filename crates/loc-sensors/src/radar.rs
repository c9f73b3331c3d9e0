//! A radar (B9): radio waves return from things with their distance, their direction, and by the
//! Doppler shift how fast they come or go.
//!
//! Of a velocity only the part along the ray is measured: something that crosses the view has none.
//! The robot's own motion is in it too, so that to a driving robot everything ahead approaches.
//! [`RadarReturn`] is one echo, [`RadarSpec`] the data sheet with its [`RadarNoise`], [`Radar`]
//! simulates it, with misses, false echoes, and walls that hide what is behind them.
//!
//! ```
//! use loc_core::{Pose2, Twist2, random::stream};
//! use loc_sensors::radar::{Radar, RadarNoise, RadarSpec};
//! use loc_sensors::world::{MovingObject, Room};
//! use nalgebra::{Point2, Vector2};
//! let spec = RadarSpec { noise: RadarNoise::NONE, ..RadarSpec::ars408_near() };
//! let radar = Radar::new(spec)?;
//! let room = Room::new([-50.0, -50.0], [50.0, 50.0])?;
//! let walker = MovingObject {
//!     position: Point2::new(10.0, 0.0),
//!     velocity: Vector2::new(-1.5, 0.5),
//!     radius: 0.0,
//! };
//! let (pose, twist) = (Pose2::IDENTITY, Twist2::forward(2.0, 0.0));
//! let echoes = radar.observe(&room, &[walker][..], pose, twist, &mut stream(1, "radar"));
//! assert!((echoes[0].radial_speed + 3.5).abs() < 1e-9, "they close in on each other");
//! # Ok::<(), loc_core::Error>(())
//! ```

use crate::Result;
use crate::check::{finite_pose, in_range, reach};
use crate::world::{MovingObject, ObjectWorld, RangeWorld};
use loc_core::error::{finite, non_negative, positive, probability};
use loc_core::{Pose2, Twist2, angle};
use nalgebra::Vector2;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, Poisson, StandardNormal};
use std::f64::consts::TAU;

/// One echo as the radar reports it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RadarReturn {
    /// Distance \[m\].
    pub range: f64,
    /// Direction, counter-clockwise from the radar's axis \[rad\].
    pub bearing: f64,
    /// How fast the distance grows, negative for what approaches \[m/s\].
    pub radial_speed: f64,
}

impl RadarReturn {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a negative distance, NaN and infinity.
    pub fn check(&self) -> Result<()> {
        non_negative("range of a radar echo [m]", self.range)?;
        finite("bearing of a radar echo [rad]", self.bearing)?;
        finite("radial speed of a radar echo [m/s]", self.radial_speed)?;
        Ok(())
    }
}

/// Independent normal errors of the three numbers, misses and false echoes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct RadarNoise {
    /// Standard deviation of the distance \[m\].
    pub range_sigma: f64,
    /// Standard deviation of the direction \[rad\].
    pub bearing_sigma: f64,
    /// Standard deviation of the radial speed \[m/s\].
    pub speed_sigma: f64,
    /// Probability that an object in view gives an echo.
    pub detection_probability: f64,
    /// How many false echoes there are in a measurement on average, evenly spread over distance,
    /// direction and speed.
    pub clutter: f64,
}

impl RadarNoise {
    /// A perfect radar.
    pub const NONE: RadarNoise = RadarNoise {
        range_sigma: 0.0,
        bearing_sigma: 0.0,
        speed_sigma: 0.0,
        detection_probability: 1.0,
        clutter: 0.0,
    };

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for negative values, NaN and infinity, a probability outside
    /// \[0, 1\], and more than 1000 false echoes.
    pub fn check(&self) -> Result<()> {
        non_negative("sigma of a radar's range [m]", self.range_sigma)?;
        non_negative("sigma of a radar's bearing [rad]", self.bearing_sigma)?;
        non_negative("sigma of a radar's radial speed [m/s]", self.speed_sigma)?;
        probability("detection probability of a radar", self.detection_probability)?;
        let few = |count: f64| (0.0..=1000.0).contains(&count);
        in_range("false echoes of a radar", "0 to 1000", self.clutter, few)?;
        Ok(())
    }
}

/// View, reach and errors of a radar.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct RadarSpec {
    /// Opening angle, half of it to each side \[rad\].
    pub fov: f64,
    /// Nearest distance \[m\].
    pub range_min: f64,
    /// Farthest distance \[m\].
    pub range_max: f64,
    /// Largest radial speed, in both directions \[m/s\].
    pub speed_max: f64,
    /// Measurements per second \[Hz\].
    pub rate: f64,
    /// Errors of the echoes.
    pub noise: RadarNoise,
}

impl RadarSpec {
    /// Continental ARS 408-21, near field: 0.2 m to 70 m, 60 deg either way, every 72 ms; accuracy
    /// 0.1 m, 1 deg (at 45 deg, better ahead) and 0.1 km/h. The data sheet's speeds reach from
    /// -400 to 200 km/h, of which the smaller bound is taken both ways.
    pub fn ars408_near() -> Self {
        RadarSpec {
            fov: 120_f64.to_radians(),
            range_min: 0.2,
            range_max: 70.0,
            speed_max: 200.0 / 3.6,
            rate: 1.0 / 0.072,
            noise: RadarNoise {
                range_sigma: 0.1,
                bearing_sigma: 1_f64.to_radians(),
                speed_sigma: 0.1 / 3.6,
                ..RadarNoise::NONE
            },
        }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for an opening angle that is not positive or of more than a
    /// turn, distances in the wrong order, a speed or rate that is not positive, and bad noise.
    pub fn check(&self) -> Result<()> {
        let opens = |fov: f64| fov > 0.0 && fov <= TAU;
        in_range("field of view of a radar [rad]", "above 0, at most a turn", self.fov, opens)?;
        reach(self.range_min, self.range_max)?;
        positive("largest radial speed [m/s]", self.speed_max)?;
        positive("measurements per second [Hz]", self.rate)?;
        self.noise.check()
    }
}

impl Default for RadarSpec {
    /// The [`RadarSpec::ars408_near`].
    fn default() -> Self {
        RadarSpec::ars408_near()
    }
}

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

    /// Velocity of the radar in the map frame \[m/s\]: mounted off the centre it also moves in
    /// turns.
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
        let offset = object.position - radar.position();
        let distance = offset.norm();
        let direction = offset.y.atan2(offset.x);
        let range = distance - object.radius;
        let bearing = angle::wrap(direction - radar.theta);
        let radial_speed = (object.velocity - velocity).dot(&offset) / distance;
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
