//! An ultrasonic ranger (B11): it emits a sound in a cone; the time until an echo returns gives one
//! distance.
//!
//! The direction of the echo within the cone is unknown. A wall at a large angle of incidence
//! reflects the sound elsewhere and gives no echo; glass, which a laser passes, gives a good one.
//! [`SonarRange`] is the measurement, [`SonarSpec`] the data sheet with its [`SonarNoise`],
//! [`Sonar`] simulates it.
//!
//! ```
//! use loc_core::{Pose2, random::stream};
//! use loc_sensors::sonar::{Sonar, SonarSpec};
//! use loc_sensors::world::Room;
//! let sonar = Sonar::new(SonarSpec::hc_sr04())?;
//! let room = Room::new([-1.0, -1.0], [2.0, 1.5])?;
//! let echo = sonar.measure(&room, Pose2::new(0.0, 0.0, 0.1), &mut stream(1, "sonar"));
//! assert!((echo.range - 2.0).abs() < 0.02, "a little to the side, the cone still holds the wall");
//! # Ok::<(), loc_core::Error>(())
//! ```

use crate::Result;
use crate::check::{count, finite_pose, in_range, reach};
use crate::world::RangeWorld;
use loc_core::Pose2;
use loc_core::error::{non_negative, probability};
use nalgebra::{Point2, Vector2};
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::{FRAC_PI_2, TAU};

/// One distance, with the meaning of the ROS message `Range`: -inf too close, +inf no echo, NaN
/// an error (REP-117).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct SonarRange {
    /// Distance \[m\].
    pub range: f64,
    /// Full opening angle of the cone in which the echo may have been \[rad\].
    pub cone: f64,
    /// Shortest distance that is a measurement \[m\].
    pub range_min: f64,
    /// Longest distance that is a measurement \[m\].
    pub range_max: f64,
}

impl SonarRange {
    /// Whether the distance is a measurement.
    pub fn is_valid(&self) -> bool {
        (self.range_min..=self.range_max).contains(&self.range)
    }

    /// Checks the numbers around the distance.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a cone that is not positive, or limits in the wrong order.
    pub fn check(&self) -> Result<()> {
        let opens = |cone: f64| cone > 0.0 && cone <= TAU;
        in_range("cone of a sonar [rad]", "above 0, at most a turn", self.cone, opens)?;
        reach(self.range_min, self.range_max)
    }
}

/// Normal errors of the distance, and echoes that are missed or of another sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct SonarNoise {
    /// Standard deviation of the distance at the sensor \[m\].
    pub sigma: f64,
    /// Its growth with the distance \[m/m\]; temperature changes the speed of sound.
    pub sigma_per_m: f64,
    /// Probability that an echo is missed: +inf.
    pub dropout: f64,
    /// Probability of receiving the sound of another sensor: any shorter distance.
    pub crosstalk: f64,
}

impl SonarNoise {
    /// A perfect sensor.
    pub const NONE: SonarNoise =
        SonarNoise { sigma: 0.0, sigma_per_m: 0.0, dropout: 0.0, crosstalk: 0.0 };

    /// Standard deviation of a distance of `range` \[m\].
    pub fn sigma_at(&self, range: f64) -> f64 {
        self.sigma + self.sigma_per_m * range
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for negative values, NaN and infinity, and for probabilities
    /// outside \[0, 1\] or with a sum above 1.
    pub fn check(&self) -> Result<()> {
        non_negative("sigma of a sonar's range [m]", self.sigma)?;
        non_negative("growth of a sonar's sigma [m/m]", self.sigma_per_m)?;
        probability("probability of a missed echo", self.dropout)?;
        probability("probability of crosstalk", self.crosstalk)?;
        let sum = self.dropout + self.crosstalk;
        in_range("sum of a sonar's fault probabilities", "at most 1", sum, |sum| sum <= 1.0)?;
        Ok(())
    }
}

/// Cone, reach and errors of an ultrasonic ranger.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct SonarSpec {
    /// Full opening angle of the cone \[rad\].
    pub cone: f64,
    /// Shortest distance \[m\].
    pub range_min: f64,
    /// Longest distance \[m\].
    pub range_max: f64,
    /// The largest angle between the sound and a wall's perpendicular that gives an echo \[rad\]:
    /// smooth walls mirror sound.
    pub widest_incidence: f64,
    /// How many rays stand for the cone in the simulation.
    pub rays: usize,
    /// Errors of the distance.
    pub noise: SonarNoise,
}

impl SonarSpec {
    /// More rays than this no cone needs.
    pub const MAX_RAYS: usize = 10_000;

    /// HC-SR04, the sensor of hobby robots: 2 cm to 4 m, 15 deg either way, ranging accuracy 3 mm.
    pub fn hc_sr04() -> Self {
        SonarSpec {
            cone: 30_f64.to_radians(),
            range_min: 0.02,
            range_max: 4.0,
            noise: SonarNoise { sigma: 0.003, ..SonarNoise::NONE },
            ..SonarSpec::default()
        }
    }

    /// Polaroid 6500, the ring around the research robots of the nineties: 0.15 m to 10.7 m, 1 %
    /// over the whole range; its main lobe is 15 deg either way.
    pub fn polaroid_6500() -> Self {
        SonarSpec {
            range_min: 0.15,
            range_max: 10.7,
            noise: SonarNoise { sigma_per_m: 0.01, ..SonarNoise::NONE },
            ..SonarSpec::default()
        }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a cone or an incidence that is not positive or too wide,
    /// distances in the wrong order and bad noise; [`crate::Error::Length`] for no rays or too
    /// many.
    pub fn check(&self) -> Result<()> {
        let opens = |cone: f64| cone > 0.0 && cone <= TAU;
        in_range("cone of a sonar [rad]", "above 0, at most a turn", self.cone, opens)?;
        let slants = |angle: f64| angle > 0.0 && angle <= FRAC_PI_2;
        let expected = "above 0, at most pi/2";
        in_range("widest incidence of a sonar [rad]", expected, self.widest_incidence, slants)?;
        count("rays of a sonar", "1 to 10000", Self::MAX_RAYS, self.rays)?;
        reach(self.range_min, self.range_max)?;
        self.noise.check()
    }
}

impl Default for SonarSpec {
    /// A perfect sensor up to 5 m, 15 deg either way.
    fn default() -> Self {
        SonarSpec {
            cone: 30_f64.to_radians(),
            range_min: 0.02,
            range_max: 5.0,
            widest_incidence: 25_f64.to_radians(),
            rays: 31,
            noise: SonarNoise::NONE,
        }
    }
}

/// An ultrasonic ranger on a robot.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct Sonar {
    /// The sensor's pose on the robot, `base_from_sonar`.
    pub mounting: Pose2,
    /// Its data sheet.
    pub spec: SonarSpec,
}

impl Sonar {
    /// A sensor in the middle of the robot.
    ///
    /// # Errors
    /// Those of [`SonarSpec::check`].
    pub fn new(spec: SonarSpec) -> Result<Self> {
        spec.check()?;
        Ok(Sonar { mounting: Pose2::IDENTITY, spec })
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a mounting that is not finite, and those of
    /// [`SonarSpec::check`].
    pub fn check(&self) -> Result<()> {
        finite_pose("mounting of a sonar", self.mounting)?;
        self.spec.check()
    }

    /// The measurement of a robot at `pose`.
    ///
    /// Draws one fault and one error, whether they matter or not.
    pub fn measure<R: Rng + ?Sized>(
        &self,
        world: &(impl RangeWorld + ?Sized),
        pose: Pose2,
        rng: &mut R,
    ) -> SonarRange {
        let spec = &self.spec;
        let fault: f64 = rng.random();
        let error: f64 = StandardNormal.sample(rng);
        let echo = self.echo(world, pose * self.mounting);
        let distance = match fault - spec.noise.dropout {
            missed if missed < 0.0 => f64::INFINITY,
            fault if fault < spec.noise.crosstalk => rng.random::<f64>() * echo.min(spec.range_max),
            _ => echo,
        };
        let range = match distance {
            f64::INFINITY => f64::INFINITY,
            _ => distance + spec.noise.sigma_at(distance) * error,
        };
        let range = match range {
            far if far > spec.range_max => f64::INFINITY,
            near if near < spec.range_min => f64::NEG_INFINITY,
            _ => range,
        };
        let SonarSpec { cone, range_min, range_max, .. } = *spec;
        SonarRange { range, cone, range_min, range_max }
    }

    /// Distance to the nearest surface in the cone that returns the sound, +inf for none.
    fn echo(&self, world: &(impl RangeWorld + ?Sized), sonar: Pose2) -> f64 {
        let rays = self.spec.rays.min(SonarSpec::MAX_RAYS);
        let step = self.spec.cone / (rays.max(2) - 1) as f64;
        let first = sonar.theta - 0.5 * step * (rays - 1) as f64;
        let reach = self.spec.range_max + 5.0 * self.spec.noise.sigma_at(self.spec.range_max);
        // One ray more on either side, for the slant of the walls at the edges.
        let mut ranges = vec![f64::INFINITY; rays + 2];
        world.cast_fan(&sonar.position(), first - step, step, reach, &mut ranges);
        for (k, range) in ranges.iter_mut().enumerate() {
            let (sin, cos) = (first + (k as f64 - 1.0) * step).sin_cos();
            let pane = nearest_pane(world, &sonar.position(), &Vector2::new(cos, sin));
            *range = if pane <= reach { range.min(pane) } else { *range };
        }
        let returns = |hit: &&[f64]| incidence(hit, step) <= self.spec.widest_incidence;
        ranges.windows(3).filter(returns).map(|hit| hit[1]).fold(f64::INFINITY, f64::min)
    }
}

/// Angle between the middle one of three neighbouring rays and the perpendicular of the wall that
/// it meets. Of the two slants to its neighbours the smaller one counts: the other may lead over an
/// edge.
fn incidence(ranges: &[f64], step: f64) -> f64 {
    let middle = ranges[1];
    let slant = |neighbour: f64| {
        // The neighbour's end, seen from the middle one's, along and across the ray.
        let (along, across) = (neighbour * step.cos() - middle, neighbour * step.sin());
        along.atan2(across).abs()
    };
    let both = [slant(ranges[0]), slant(ranges[2])];
    both.into_iter().filter(|angle| angle.is_finite()).fold(f64::INFINITY, f64::min)
}

fn nearest_pane(
    world: &(impl RangeWorld + ?Sized),
    origin: &Point2<f64>,
    along: &Vector2<f64>,
) -> f64 {
    let panes = world.panes().iter().filter_map(|pane| pane.distance(origin, along));
    panes.fold(f64::INFINITY, f64::min)
}
