//! The feature: a straight wall.

use loc_core::{Pose2, angle};
use nalgebra::{Matrix2, Point2, Vector2};

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
