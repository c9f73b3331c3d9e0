//! The feature: a straight wall.

use super::LineExtractor;
use crate::laser::Beam;
use loc_core::{Pose2, angle};
use nalgebra::{Matrix2, Point2, Vector2};
use std::f64::consts::PI;

/// A line `x cos(alpha) + y sin(alpha) = r` with the stretch of it that was seen.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Line {
    /// Distance from the origin, at least 0 \[m\]; also known as rho or d.
    pub r: f64,
    /// Direction of the perpendicular from the origin \[rad\]; also known as psi.
    pub alpha: f64,
    /// Covariance of (r, alpha) \[m^2, m rad, rad^2\].
    pub covariance: Matrix2<f64>,
    /// Where the stretch that was seen begins, on the line \[m\].
    pub start: Point2<f64>,
    /// Where it ends, in the order of the beams \[m\].
    pub end: Point2<f64>,
    /// How many beams the line was fitted to.
    pub points: usize,
}

impl Line {
    /// Signed distance of a point from the line, positive beyond it \[m\].
    pub fn distance(&self, point: &Point2<f64>) -> f64 {
        self.normal().dot(&point.coords) - self.r
    }

    /// The unit vector perpendicular to the line, away from the origin.
    pub fn normal(&self) -> Vector2<f64> {
        let (sin, cos) = self.alpha.sin_cos();
        Vector2::new(cos, sin)
    }

    /// The point of the line nearest to `point` \[m\].
    pub fn foot(&self, point: &Point2<f64>) -> Point2<f64> {
        point - self.normal() * self.distance(point)
    }

    /// Length of the stretch that was seen \[m\].
    pub fn length(&self) -> f64 {
        nalgebra::distance(&self.start, &self.end)
    }

    /// Where two lines cross; `None` for nearly parallel ones (below half a degree).
    pub fn crossing(&self, other: &Line) -> Option<Point2<f64>> {
        let (a, b) = (self.normal(), other.normal());
        let sine = a.perp(&b);
        let x = (self.r * b.y - other.r * a.y) / sine;
        let y = (other.r * a.x - self.r * b.x) / sine;
        (sine.abs() > 0.009).then(|| Point2::new(x, y))
    }

    /// The same line in a frame in which this one's sits at `pose` (`base_from_laser`, or
    /// `map_from_laser` where that is known), its covariance propagated to first order.
    #[must_use]
    pub fn transformed(&self, pose: Pose2) -> Line {
        let alpha = self.alpha + pose.theta;
        let (sin, cos) = alpha.sin_cos();
        let r = self.r + pose.x * cos + pose.y * sin;
        let by_alpha = pose.y * cos - pose.x * sin;
        // A line on the other side of the new origin turns round to keep r >= 0.
        let (sign, turn) = if r < 0.0 { (-1.0, std::f64::consts::PI) } else { (1.0, 0.0) };
        let jacobian = Matrix2::new(sign, sign * by_alpha, 0.0, 1.0);
        Line {
            r: sign * r,
            alpha: angle::wrap(alpha + turn),
            covariance: jacobian * self.covariance * jacobian.transpose(),
            start: pose.transform(&self.start),
            end: pose.transform(&self.end),
            points: self.points,
        }
    }
}

/// A beam with what the fit needs of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hit {
    pub(super) beam: Beam,
    pub(super) point: Point2<f64>,
    pub(super) range_variance: f64,
    pub(super) angle_variance: f64,
    pub(super) wall_variance: f64,
}

/// Lower bound of the roughness of a wall, so that perfect ranges have a finite weight \[m\].
const MIN_ROUGHNESS: f64 = 1e-6;

impl Hit {
    pub(super) fn new(beam: Beam, settings: &LineExtractor) -> Self {
        Hit {
            beam,
            point: beam.point(),
            range_variance: settings.noise.sigma_at(beam.range).powi(2),
            angle_variance: settings.angle_sigma.powi(2),
            wall_variance: settings.roughness.max(MIN_ROUGHNESS).powi(2),
        }
    }

    /// Variance of the distance from a line whose perpendicular points to `alpha` \[m^2\].
    pub(super) fn variance(&self, alpha: f64) -> f64 {
        let (sin, cos) = alpha.sin_cos();
        self.variance_along(cos, sin)
    }

    /// The same from cosine and sine of `alpha`.
    fn variance_along(&self, cos: f64, sin: f64) -> f64 {
        let square = self.beam.range * self.beam.range;
        let beyond = self.point.x * cos + self.point.y * sin;
        let cos_squared = beyond * beyond / square;
        let across = self.angle_variance * (square - beyond * beyond);
        self.range_variance * cos_squared + across + self.wall_variance
    }
}

/// Iterations of reweighting; after two the third digit of a standard deviation is final.
const ROUNDS: usize = 2;

/// The line of the weighted total least squares; `None` for fewer than two points, or points in one
/// place.
///
/// The distance of a point from its wall has the range's error times the cosine of the angle of
/// incidence, and the angle's error times range and sine. The fit weights each point by the inverse
/// of that variance (Pfister, Roumeliotis and Burdick 2003), which depends on the line itself: a
/// few iterations converge, and [`refined`] removes the remaining bias. The covariance is the
/// inverse of the information of all points about (r, alpha).
pub(super) fn fit(hits: &[Hit]) -> Option<Line> {
    let (mut r, mut alpha) = weighted(hits, |_| 1.0)?;
    for _ in 0..ROUNDS {
        let (sin, cos) = alpha.sin_cos();
        (r, alpha) = weighted(hits, |hit| 1.0 / hit.variance_along(cos, sin))?;
    }
    line(hits, r, alpha)
}

/// The same without the fit's bias, for the final walls.
///
/// The weights were held while the line turned, but a point's noise turns with its beam; that
/// pulls the line by an order of noise squared. Two Gauss-Newton steps on the likelihood of the
/// beams themselves take it out.
pub(super) fn refined(hits: &[Hit]) -> Option<Line> {
    let start = fit(hits)?;
    let (mut r, mut alpha) = (start.r, start.alpha);
    for _ in 0..2 {
        let step = Information::of(hits, r, alpha);
        let change = step.covariance()? * step.gradient;
        (r, alpha) = (r + change.x, alpha + change.y);
    }
    line(hits, r, alpha)
}

fn line(hits: &[Hit], r: f64, alpha: f64) -> Option<Line> {
    let (r, alpha) = if r < 0.0 { (-r, alpha + PI) } else { (r, alpha) };
    let covariance = Information::of(hits, r, alpha).covariance()?;
    let (first, last) = (hits.first()?.point, hits.last()?.point);
    let alpha = angle::wrap(alpha);
    let line = Line { r, alpha, covariance, start: first, end: last, points: hits.len() };
    Some(Line { start: line.foot(&first), end: line.foot(&last), ..line })
}

/// (r, alpha) of the line with the least sum of weighted squared distances: it passes through the
/// weighted mean, along the longer axis of the scatter.
fn weighted(hits: &[Hit], weight: impl Fn(&Hit) -> f64) -> Option<(f64, f64)> {
    let (mut total, mut x, mut y) = (0.0, 0.0, 0.0);
    for hit in hits {
        let w = weight(hit);
        (total, x, y) = (total + w, x + w * hit.point.x, y + w * hit.point.y);
    }
    let (x, y) = (x / total, y / total);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for hit in hits {
        let (w, dx, dy) = (weight(hit), hit.point.x - x, hit.point.y - y);
        (xx, xy, yy) = (xx + w * dx * dx, xy + w * dx * dy, yy + w * dy * dy);
    }
    let alpha = 0.5 * (-2.0 * xy).atan2(yy - xx);
    let (sin, cos) = alpha.sin_cos();
    let spread = xx + yy;
    (hits.len() >= 2 && spread > 0.0 && spread.is_finite()).then_some((x * cos + y * sin, alpha))
}

/// The information of all points about (r, alpha): the normal equations at a line.
struct Information {
    matrix: Matrix2<f64>,
    gradient: Vector2<f64>,
}

impl Information {
    fn of(hits: &[Hit], r: f64, alpha: f64) -> Self {
        let (sin, cos) = alpha.sin_cos();
        let (mut a, mut b, mut c) = (0.0, 0.0, 0.0);
        let mut gradient = Vector2::zeros();
        for hit in hits {
            let beyond = hit.point.x * cos + hit.point.y * sin;
            let along = hit.point.y * cos - hit.point.x * sin;
            let (off, w) = (beyond - r, 1.0 / hit.variance_along(cos, sin));
            // The distance changes by -1 with r, and with alpha by the place along the line: that
            // of the line's point on this beam, not that of the noisy one.
            let square = hit.beam.range * hit.beam.range;
            let turning = beyond * along * (hit.range_variance / square - hit.angle_variance);
            let lever = along - off * w * turning;
            (a, b, c) = (a + w, b - w * lever, c + w * lever * lever);
            gradient += Vector2::new(off, -off * lever) * w;
        }
        Information { matrix: Matrix2::new(a, b, b, c), gradient }
    }

    fn covariance(&self) -> Option<Matrix2<f64>> {
        let [a, b, c] = [self.matrix.m11, self.matrix.m12, self.matrix.m22];
        let determinant = a * c - b * b;
        (determinant > 1e-12 * a * c).then(|| Matrix2::new(c, -b, -b, a) / determinant)
    }
}
