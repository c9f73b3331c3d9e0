//! The simulated scanner: ray casting, glass and mirrors, noise and faults.

use super::{LaserFaults, LaserScan, LaserSpec};
use crate::Result;
use crate::check::finite_pose;
use crate::world::{RangeWorld, Surface};
use loc_core::{Pose2, Twist2};
use nalgebra::{Point2, Vector2};
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

/// A laser scanner on a robot.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct LaserScanner {
    /// The scanner's pose on the robot, `base_from_laser`.
    pub mounting: Pose2,
    /// Its data sheet.
    pub spec: LaserSpec,
    /// Faults of single beams.
    pub faults: LaserFaults,
}

impl LaserScanner {
    /// A scanner in the middle of the robot, without faults.
    ///
    /// # Errors
    /// Those of [`LaserSpec::check`].
    pub fn new(spec: LaserSpec) -> Result<Self> {
        spec.check()?;
        Ok(LaserScanner { spec, ..LaserScanner::default() })
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a mounting that is not finite, and those of
    /// [`LaserSpec::check`] and [`LaserFaults::check`].
    pub fn check(&self) -> Result<()> {
        finite_pose("mounting of a laser", self.mounting)?;
        self.spec.check()?;
        self.faults.check()
    }

    /// The scan of a robot that stands at `pose`.
    pub fn scan<R: Rng + ?Sized>(
        &self,
        world: &(impl RangeWorld + ?Sized),
        pose: Pose2,
        rng: &mut R,
    ) -> LaserScan {
        let laser = pose * self.mounting;
        let (origin, first) = (laser.position(), laser.theta + self.spec.angle_min);
        let mut ranges = vec![f64::INFINITY; self.beams()];
        let (step, reach) = (self.spec.angle_increment, self.reach());
        world.cast_fan(&origin, first, step, reach, &mut ranges);
        let glazed = !world.panes().is_empty();
        for (k, range) in ranges.iter_mut().enumerate() {
            if glazed {
                *range = through_panes(world, origin, first + k as f64 * step, *range, reach, rng);
            }
            *range = self.report(*range, rng);
        }
        self.spec.scan(ranges)
    }

    /// The scan of a robot that is at `pose` for beam 0 and then moves on with constant velocity.
    pub fn scan_moving<R: Rng + ?Sized>(
        &self,
        world: &(impl RangeWorld + ?Sized),
        pose: Pose2,
        twist: Twist2,
        rng: &mut R,
    ) -> LaserScan {
        let path = |time: f64| pose * Pose2::exp(&(twist.to_vector() * time));
        self.scan_along(world, path, rng)
    }

    /// The scan of a robot whose pose is `path(t)`, t \[s\] after beam 0.
    pub fn scan_along<R: Rng + ?Sized>(
        &self,
        world: &(impl RangeWorld + ?Sized),
        path: impl Fn(f64) -> Pose2,
        rng: &mut R,
    ) -> LaserScan {
        let (spec, reach, time_step) = (&self.spec, self.reach(), self.spec.time_increment());
        let measure = |k: usize| {
            let laser = path(k as f64 * time_step) * self.mounting;
            let direction = laser.theta + spec.angle_min + k as f64 * spec.angle_increment;
            let wall = world.cast(&laser.position(), direction, reach).unwrap_or(f64::INFINITY);
            let range = through_panes(world, laser.position(), direction, wall, reach, rng);
            self.report(range, rng)
        };
        spec.scan((0..self.beams()).map(measure).collect())
    }

    /// Number of beams, limited even where the settings were not checked.
    fn beams(&self) -> usize {
        self.spec.beams.min(LaserScan::MAX_BEAMS)
    }

    /// Range of the ray casting: noise may bring a surface slightly beyond the maximum into range.
    fn reach(&self) -> f64 {
        self.spec.range_max + 5.0 * self.spec.noise.sigma_at(self.spec.range_max)
    }

    /// The reported range for a true distance \[m\], +inf for none.
    ///
    /// Draws one fault and one error for every beam, whether they matter or not.
    fn report<R: Rng + ?Sized>(&self, distance: f64, rng: &mut R) -> f64 {
        let fault: f64 = rng.random();
        let error: f64 = StandardNormal.sample(rng);
        let LaserFaults { dropout, erroneous, short } = self.faults;
        if fault < dropout + erroneous {
            return if fault < dropout { f64::INFINITY } else { f64::NAN };
        }
        let true_range = if fault < dropout + erroneous + short {
            rng.random::<f64>() * distance.min(self.spec.range_max)
        } else if distance < f64::INFINITY {
            distance
        } else {
            return f64::INFINITY;
        };
        let range = true_range + self.spec.noise.sigma_at(true_range) * error;
        if range > self.spec.range_max {
            f64::INFINITY
        } else if range < self.spec.range_min {
            f64::NEG_INFINITY
        } else {
            range
        }
    }
}

/// Number of panes after which a beam counts as lost, as between two mirrors.
const MAX_PANES: usize = 16;

/// Length of the path \[m\] that a beam takes through the panes of a world until it returns, +inf
/// where it does not within `reach`. `wall` is the distance to the first wall without them.
pub(super) fn through_panes<R: Rng + ?Sized>(
    world: &(impl RangeWorld + ?Sized),
    mut origin: Point2<f64>,
    mut direction: f64,
    mut wall: f64,
    reach: f64,
    rng: &mut R,
) -> f64 {
    let (mut travelled, mut last) = (0.0, None);
    for _ in 0..MAX_PANES {
        let (sin, cos) = direction.sin_cos();
        let along = Vector2::new(cos, sin);
        let Some((index, distance)) = nearest(world, &origin, &along, last) else {
            return travelled + wall;
        };
        if distance >= wall || travelled + distance > reach {
            return travelled + wall;
        }
        origin += along * distance;
        travelled += distance;
        last = Some(index);
        match world.panes()[index].surface {
            Surface::Glass { pass } if rng.random::<f64>() >= pass => return travelled,
            Surface::Glass { .. } => wall -= distance,
            Surface::Mirror => {
                direction = world.panes()[index].reflect(direction);
                let rest = reach - travelled;
                wall = world.cast(&origin, direction, rest).unwrap_or(f64::INFINITY);
            }
        }
    }
    f64::INFINITY
}

/// The nearest pane along a ray and its distance \[m\], without the one that the ray starts on.
fn nearest(
    world: &(impl RangeWorld + ?Sized),
    origin: &Point2<f64>,
    along: &Vector2<f64>,
    start: Option<usize>,
) -> Option<(usize, f64)> {
    let panes = world.panes().iter().enumerate().filter(|(index, _)| Some(*index) != start);
    panes
        .filter_map(|(index, pane)| pane.distance(origin, along).map(|range| (index, range)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
}
