//! The simulated ranger.

use super::{SonarRange, SonarSpec};
use crate::Result;
use crate::check::finite_pose;
use crate::world::RangeWorld;
use loc_core::Pose2;
use nalgebra::{Point2, Vector2};
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

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

    /// The echo that a robot at `pose` hears.
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
            heard if heard < spec.noise.crosstalk => rng.random::<f64>() * echo.min(spec.range_max),
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
