//! Mean and covariance of a weighted cloud.

use super::heading::{sin_cos, wrapped};
use super::lanes::{LANES, Lanes, Sums, add_all};
use crate::workers::PART;
use crate::{Particles, Poses, Workers};
use loc_core::Gaussian;
use nalgebra::{Matrix3, Vector3};
use pulp::{Arch, Simd, WithSimd};
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
    particles.relative_weights(&mut weights);
    weighted_moments(&Workers::one(), particles.poses(), &weights)
}

/// The same with weights that are not logarithms, by several threads.
pub(super) fn weighted_moments(
    workers: &Workers,
    poses: Poses<'_>,
    weights: &[f64],
) -> Gaussian<3> {
    let parts = || poses.chunks(PART).zip(weights.chunks(PART));
    let sums =
        workers.map(parts(), |(poses, weights)| Arch::new().dispatch(AddFirst { poses, weights }));
    let center = sums.into_iter().fold(FirstSums::default(), FirstSums::plus).center();
    let sums = workers.map(parts(), |(poses, weights)| {
        Arch::new().dispatch(AddSecond { poses, weights, center: &center })
    });
    sums.into_iter().fold(SecondSums::default(), SecondSums::plus).gaussian(&center)
}

/// Adds up [`FirstSums`] of a part.
struct AddFirst<'a> {
    poses: Poses<'a>,
    weights: &'a [f64],
}

impl WithSimd for AddFirst<'_> {
    type Output = FirstSums;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> FirstSums {
        let mut lanes = FirstLanes::default();
        add_all(&mut lanes, self.poses, self.weights);
        let FirstLanes([weight, x, y, sin, cos]) = lanes;
        let sums = (0..LANES).map(|k| FirstSums {
            weight: weight[k],
            x: x[k],
            y: y[k],
            sin: sin[k],
            cos: cos[k],
        });
        sums.fold(FirstSums::default(), FirstSums::plus)
    }
}

/// [`FirstSums`] of every `LANES`-th particle.
#[derive(Default)]
struct FirstLanes([Lanes; 5]);

impl Sums for FirstLanes {
    #[inline(always)]
    fn add(&mut self, x: &Lanes, y: &Lanes, theta: &Lanes, weight: &Lanes) {
        let FirstLanes([weights, xs, ys, sines, cosines]) = self;
        for k in 0..LANES {
            let (sin, cos) = sin_cos(theta[k]);
            weights[k] += weight[k];
            xs[k] += weight[k] * x[k];
            ys[k] += weight[k] * y[k];
            sines[k] += weight[k] * sin;
            cosines[k] += weight[k] * cos;
        }
    }
}

/// Adds up [`SecondSums`] of a part.
struct AddSecond<'a> {
    poses: Poses<'a>,
    weights: &'a [f64],
    center: &'a Center,
}

impl WithSimd for AddSecond<'_> {
    type Output = SecondSums;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> SecondSums {
        let mut lanes = SecondLanes { center: *self.center, sums: Default::default() };
        add_all(&mut lanes, self.poses, self.weights);
        let [xx, xy, yy, xt, yt, tt] = lanes.sums;
        let sums = (0..LANES).map(|k| SecondSums {
            xx: xx[k],
            xy: xy[k],
            yy: yy[k],
            xt: xt[k],
            yt: yt[k],
            tt: tt[k],
        });
        sums.fold(SecondSums::default(), SecondSums::plus)
    }
}

/// [`SecondSums`] of every `LANES`-th particle.
struct SecondLanes {
    center: Center,
    sums: [Lanes; 6],
}

impl Sums for SecondLanes {
    #[inline(always)]
    fn add(&mut self, x: &Lanes, y: &Lanes, theta: &Lanes, weight: &Lanes) {
        let [xx, xy, yy, xt, yt, tt] = &mut self.sums;
        for k in 0..LANES {
            let (dx, dy) = (x[k] - self.center.x, y[k] - self.center.y);
            let dt = wrapped(theta[k] - self.center.theta);
            let (wx, wy, wt) = (weight[k] * dx, weight[k] * dy, weight[k] * dt);
            xx[k] += wx * dx;
            xy[k] += wx * dy;
            yy[k] += wy * dy;
            xt[k] += wx * dt;
            yt[k] += wy * dt;
            tt[k] += wt * dt;
        }
    }
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
    pub(super) fn add(&mut self, x: f64, y: f64, (sin, cos): (f64, f64), weight: f64) {
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
        let resultant = (self.sin * self.sin + self.cos * self.cos).sqrt();
        let directed = resultant > 1e-12 * self.weight;
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
