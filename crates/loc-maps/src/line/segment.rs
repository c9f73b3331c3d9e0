//! One straight line from a point to another.

use crate::bounds::coordinate;
use crate::tree::{Bounded, Ray};
use crate::{Bounds, Result};
use loc_core::{Pose2, angle};
use nalgebra::{Point2, Vector2};

/// Rays that start on a line, up to rounding, hit it \[m\].
const ON_LINE: f64 = 1e-9;

/// A straight wall between two points.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LineSegment {
    /// Where it starts \[m\].
    pub start: Point2<f64>,
    /// Where it ends \[m\].
    pub end: Point2<f64>,
}

/// A line without ends in Hessian normal form: `x cos(alpha) + y sin(alpha) = r`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NormalForm {
    /// Distance of the line from the origin \[m\], at least 0.
    pub r: f64,
    /// Direction from the origin to the nearest point of the line \[rad\], in (-pi, pi].
    pub alpha: f64,
}

impl LineSegment {
    /// The line from one point to another \[m\].
    pub fn new(start: [f64; 2], end: [f64; 2]) -> Self {
        LineSegment { start: start.into(), end: end.into() }
    }

    /// Its length \[m\].
    pub fn length(&self) -> f64 {
        nalgebra::distance(&self.start, &self.end)
    }

    /// The point at a fraction of the way, 0 the start and 1 the end \[m\].
    pub fn at(&self, fraction: f64) -> Point2<f64> {
        self.start + (self.end - self.start) * fraction
    }

    /// Its direction from start to end \[rad\].
    pub fn direction(&self) -> f64 {
        let along = self.end - self.start;
        along.y.atan2(along.x)
    }

    /// The line as seen from a frame at `pose`.
    #[must_use]
    pub fn seen_from(&self, pose: Pose2) -> LineSegment {
        let into_frame = pose.inverse();
        LineSegment {
            start: into_frame.transform(&self.start),
            end: into_frame.transform(&self.end),
        }
    }

    /// The line it lies on, in the frame of its coordinates.
    ///
    /// Where that passes through the origin, alpha is a quarter turn left of its direction.
    pub fn normal_form(&self) -> NormalForm {
        let normal = self.direction() + std::f64::consts::FRAC_PI_2;
        let (sin, cos) = normal.sin_cos();
        // The middle of the ends, for their errors cancel there.
        let middle = self.at(0.5);
        let r = middle.x * cos + middle.y * sin;
        let turned = if r < 0.0 { normal + std::f64::consts::PI } else { normal };
        NormalForm { r: r.abs(), alpha: angle::wrap(turned) }
    }

    /// Fraction of the way at which a point is nearest, in \[0, 1\].
    pub fn nearest_fraction(&self, point: &Point2<f64>) -> f64 {
        let along = self.end - self.start;
        let fraction = (point - self.start).dot(&along) / along.norm_squared();
        // A line without length is all start.
        if fraction.is_nan() { 0.0 } else { fraction.clamp(0.0, 1.0) }
    }

    /// Distance of a point \[m\].
    pub fn distance(&self, point: &Point2<f64>) -> f64 {
        nalgebra::distance(point, &self.at(self.nearest_fraction(point)))
    }

    /// How far a ray from `origin` \[m\] in `direction` \[rad\] runs until it hits, ends included.
    ///
    /// No ray slips between two lines with a common end. A ray that starts on the line hits it at
    /// 0, one that runs along it at its nearer end.
    pub fn cast(&self, origin: &Point2<f64>, direction: f64) -> Option<f64> {
        self.hit(&Ray::new(origin, direction))
    }

    #[inline]
    pub(crate) fn hit(&self, ray: &Ray) -> Option<f64> {
        let (a, b) = (self.start - ray.origin, self.end - ray.origin);
        // On which side of the ray each end lies: a common end of two lines lies on the same side
        // for both, whatever the rounding.
        let (side_a, side_b) = (a.perp(&ray.along), b.perp(&ray.along));
        if (side_a > 0.0 && side_b > 0.0) || (side_a < 0.0 && side_b < 0.0) {
            return None;
        }
        let (far_a, far_b) = (a.dot(&ray.along), b.dot(&ray.along));
        let across = side_b - side_a;
        if across.abs() <= 0.0 {
            return along_the_line(far_a, far_b);
        }
        let far = (far_a * side_b - far_b * side_a) / across;
        (far >= -ON_LINE).then_some(far.max(0.0))
    }

    /// Checks that both ends are places in a robot's world, and not the same one.
    pub(crate) fn checked(self) -> Result<Self> {
        for value in [self.start.x, self.start.y, self.end.x, self.end.y] {
            coordinate("end of a line [m]", value)?;
        }
        if self.has_length() {
            return Ok(self);
        }
        Err(crate::Error::LineWithoutLength { x: self.start.x, y: self.start.y })
    }

    /// Whether the ends are two places, also where squares of numbers vanish.
    pub(crate) fn has_length(&self) -> bool {
        (self.end - self.start).norm_squared() > 0.0
    }
}

/// The nearer of two ends straight ahead, 0 between them.
fn along_the_line(far_a: f64, far_b: f64) -> Option<f64> {
    (far_a.max(far_b) >= -ON_LINE).then_some(far_a.min(far_b).max(0.0))
}

impl NormalForm {
    /// Signed distance of a point \[m\]: negative on the side of the origin.
    pub fn signed_distance(&self, point: &Point2<f64>) -> f64 {
        let (sin, cos) = self.alpha.sin_cos();
        point.coords.dot(&Vector2::new(cos, sin)) - self.r
    }
}

impl Bounded for LineSegment {
    fn bounds(&self) -> Bounds {
        Bounds { min: self.start.inf(&self.end), max: self.start.sup(&self.end) }
    }
}
