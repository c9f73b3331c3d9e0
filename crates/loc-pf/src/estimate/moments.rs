//! Mean and covariance of a weighted cloud.

use super::heading::{sin_cos, wrapped};
use super::weights::{LANES, in_lanes, relative_weights};
use crate::{Particles, Poses};
use loc_core::Gaussian;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

/// Weighted mean and covariance of all particles.
///
/// The mean heading is the direction of the sum of the unit vectors (circular mean); deviations
/// from it are wrapped, so that a cloud about +-pi is as narrow as any other. Weights need not add
/// up to 1.
///
/// Where that sum vanishes (headings evenly all round, two opposite ones), no heading is better
/// than another: the mean is then 0 with the variance of a heading that is not known at all,
/// pi^2 / 3, uncorrelated with the position. Particles that are not finite count for nothing; a
/// cloud without any others has the mean 0, no spread in position and an unknown heading.
///
/// ```
/// use loc_core::Pose2;
/// use loc_pf::{Particles, estimate::moments};
/// let cloud = Particles::from_poses([Pose2::new(1.0, 0.0, 3.1), Pose2::new(3.0, 0.0, -3.1)]);
/// let belief = moments(&cloud);
/// assert!((belief.mean.x - 2.0).abs() < 1e-12 && belief.mean.z.abs() > 3.14);
/// assert!((belief.covariance.m33.sqrt() - 0.0416).abs() < 1e-4);
/// ```
pub fn moments(particles: &Particles) -> Gaussian<3> {
    let mut weights = Vec::new();
    relative_weights(particles, &mut weights);
    weighted_moments(particles.poses(), &weights)
}

/// The same with weights that are not logarithms.
pub(super) fn weighted_moments(poses: Poses<'_>, weights: &[f64]) -> Gaussian<3> {
    let mut lanes = [FirstSums::default(); LANES];
    in_lanes(poses, weights, |x, y, theta, weight| {
        for k in 0..LANES {
            lanes[k].add(x[k], y[k], theta[k], weight[k]);
        }
    });
    let center = lanes.into_iter().fold(FirstSums::default(), FirstSums::plus).center();
    let mut lanes = [SecondSums::default(); LANES];
    in_lanes(poses, weights, |x, y, theta, weight| {
        for k in 0..LANES {
            lanes[k].add(&center, x[k], y[k], theta[k], weight[k]);
        }
    });
    lanes.into_iter().fold(SecondSums::default(), SecondSums::plus).gaussian(&center)
}

/// Sums that the mean is made of.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct FirstSums {
    pub(super) weight: f64,
    x: f64,
    y: f64,
    sin: f64,
    cos: f64,
}

impl FirstSums {
    #[inline(always)]
    pub(super) fn add(&mut self, x: f64, y: f64, theta: f64, weight: f64) {
        let (sin, cos) = sin_cos(theta);
        self.weight += weight;
        self.x += weight * x;
        self.y += weight * y;
        self.sin += weight * sin;
        self.cos += weight * cos;
    }

    fn plus(self, other: FirstSums) -> FirstSums {
        FirstSums {
            weight: self.weight + other.weight,
            x: self.x + other.x,
            y: self.y + other.y,
            sin: self.sin + other.sin,
            cos: self.cos + other.cos,
        }
    }

    pub(super) fn center(&self) -> Center {
        if self.weight <= 0.0 {
            return Center::default();
        }
        // A resultant at the level of rounding has no direction.
        let directed = f64::hypot(self.sin, self.cos) > 1e-12 * self.weight;
        Center {
            weight: self.weight,
            x: self.x / self.weight,
            y: self.y / self.weight,
            theta: if directed { self.sin.atan2(self.cos) } else { 0.0 },
            directed,
        }
    }
}

/// A mean, from which deviations are taken.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Center {
    pub(super) weight: f64,
    x: f64,
    y: f64,
    theta: f64,
    /// Whether there is a mean heading.
    directed: bool,
}

/// Sums that the covariance is made of.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SecondSums {
    xx: f64,
    xy: f64,
    yy: f64,
    xt: f64,
    yt: f64,
    tt: f64,
}

impl SecondSums {
    #[inline(always)]
    pub(super) fn add(&mut self, center: &Center, x: f64, y: f64, theta: f64, weight: f64) {
        let (dx, dy, dt) = (x - center.x, y - center.y, wrapped(theta - center.theta));
        let (wx, wy, wt) = (weight * dx, weight * dy, weight * dt);
        self.xx += wx * dx;
        self.xy += wx * dy;
        self.yy += wy * dy;
        self.xt += wx * dt;
        self.yt += wy * dt;
        self.tt += wt * dt;
    }

    fn plus(self, other: SecondSums) -> SecondSums {
        SecondSums {
            xx: self.xx + other.xx,
            xy: self.xy + other.xy,
            yy: self.yy + other.yy,
            xt: self.xt + other.xt,
            yt: self.yt + other.yt,
            tt: self.tt + other.tt,
        }
    }

    pub(super) fn gaussian(&self, center: &Center) -> Gaussian<3> {
        let mean = Vector3::new(center.x, center.y, center.theta);
        let scale = if center.weight > 0.0 { 1.0 / center.weight } else { 0.0 };
        let [xx, xy, yy] = [self.xx, self.xy, self.yy].map(|sum| sum * scale);
        let [xt, yt, tt] = if center.directed {
            [self.xt, self.yt, self.tt].map(|sum| sum * scale)
        } else {
            [0.0, 0.0, PI * PI / 3.0]
        };
        Gaussian { mean, covariance: Matrix3::new(xx, xy, xt, xy, yy, yt, xt, yt, tt) }
    }
}
