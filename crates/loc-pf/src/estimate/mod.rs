//! The estimate of the pose from particles: mean, covariance, and clusters.
//!
//! A particle filter represents many poses; a robot needs one to act on. While the particles are a
//! single cluster, their mean and covariance ([`moments`]) suffice. When the robot may be in any of
//! three similar rooms, the mean of all particles lies in none of them: then the clusters
//! ([`Clusterer`]) are the hypotheses, each with its share, and the heaviest is reported.
//!
//! ```
//! use loc_core::{Pose2, gaussian::pose_belief, random::stream};
//! use loc_pf::Particles;
//! use loc_pf::estimate::{ClusterSettings, Clusterer};
//! let belief = pose_belief(Pose2::new(4.0, 2.0, 3.1), [0.1, 0.1, 0.05]);
//! let particles = Particles::from_gaussian(&belief, 1000, &mut stream(1, "cloud"));
//! let estimate = Clusterer::new(ClusterSettings::default())?.estimate(&particles);
//! assert_eq!(estimate.clusters.len(), 1);
//! assert!(estimate.belief.pose().distance(Pose2::new(4.0, 2.0, 3.1)) < 0.02);
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod clusters;

pub use clusters::{Cluster, ClusterSettings, Clusterer, PoseSource};

use crate::workers::PART;
use crate::{Particles, Poses, Workers};
use loc_core::{Gaussian, angle};
use nalgebra::{Matrix3, Vector3};
use pulp::{Arch, Simd, WithSimd};
use std::f64::consts::{FRAC_2_PI, PI, TAU};

/// The estimate of the pose from particles.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The pose to act on, over (x, y, theta) \[m, m, rad\]: mean and covariance of the heaviest
    /// cluster, or of all particles by [`ClusterSettings::pose`].
    pub belief: Gaussian<3>,
    /// All clusters, the heaviest first; none without particles.
    pub clusters: Vec<Cluster>,
}

impl Estimate {
    /// Share of the heaviest cluster; 0 without particles.
    pub fn share(&self) -> f64 {
        self.clusters.first().map_or(0.0, |cluster| cluster.share)
    }

    /// The reported pose with the second moments of the whole belief about it: of a belief with
    /// several clusters, how far the robot may be from the pose. Between clusters, position and
    /// heading are taken as uncorrelated: of opposite headings, either turn is the difference.
    pub fn whole(&self) -> Gaussian<3> {
        let Gaussian { mean, .. } = self.belief;
        let parts = self.clusters.iter().map(|Cluster { share, belief, .. }| {
            let mut apart = belief.mean - mean;
            apart.z = angle::wrap(apart.z);
            let mut between = apart * apart.transpose();
            for k in 0..2 {
                (between[(k, 2)], between[(2, k)]) = (0.0, 0.0);
            }
            (belief.covariance + between) * *share
        });
        parts
            .reduce(|sum, part| sum + part)
            .map_or(self.belief, |sum| Gaussian { mean, covariance: sum })
    }
}

impl Clusterer {
    /// Clusters particles and estimates the pose from them.
    pub fn estimate(&mut self, particles: &Particles) -> Estimate {
        let clusters = self.clusters(particles);
        let heaviest = clusters.first().map(|cluster| cluster.belief);
        let belief = match self.settings().pose {
            PoseSource::HeaviestCluster => heaviest,
            PoseSource::WholeCloud => None,
        };
        Estimate { belief: belief.unwrap_or_else(|| moments(particles)), clusters }
    }
}

/// Weighted mean and covariance of all particles.
///
/// The mean heading is the direction of the sum of the unit vectors (circular mean); deviations
/// from it are wrapped, so that a particle set about +-pi is as narrow as any other. Weights need
/// not add up to 1.
///
/// Where that sum vanishes (headings evenly all round, two opposite ones), no heading is better
/// than another: the mean is then 0 with the variance of an unknown heading, pi^2 / 3, uncorrelated
/// with the position. Particles that are not finite do not count; a particle set without any others
/// has the mean 0, no spread in position and an unknown heading.
///
/// ```
/// use loc_core::Pose2;
/// use loc_pf::{Particles, estimate::moments};
/// let particles = Particles::from_poses([Pose2::new(1.0, 0.0, 3.1), Pose2::new(3.0, 0.0, -3.1)]);
/// let belief = moments(&particles);
/// assert!((belief.mean.x - 2.0).abs() < 1e-12 && belief.mean.z.abs() > 3.14);
/// assert!((belief.covariance.m33.sqrt() - 0.0416).abs() < 1e-4);
/// ```
pub fn moments(particles: &Particles) -> Gaussian<3> {
    let mut weights = Vec::new();
    particles.relative_weights(&mut weights);
    weighted_moments(&Workers::one(), particles.poses(), &weights)
}

/// The same with weights that are not logarithms, by several threads.
fn weighted_moments(workers: &Workers, poses: Poses<'_>, weights: &[f64]) -> Gaussian<3> {
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

/// Sums for the mean.
#[derive(Debug, Clone, Copy, Default)]
struct FirstSums {
    weight: f64,
    x: f64,
    y: f64,
    sin: f64,
    cos: f64,
}

impl FirstSums {
    #[inline(always)]
    fn add(&mut self, x: f64, y: f64, (sin, cos): (f64, f64), weight: f64) {
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

    fn center(&self) -> Center {
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
struct Center {
    weight: f64,
    x: f64,
    y: f64,
    theta: f64,
    /// Whether there is a mean heading.
    directed: bool,
}

/// Sums for the covariance.
#[derive(Debug, Clone, Copy, Default)]
struct SecondSums {
    xx: f64,
    xy: f64,
    yy: f64,
    xt: f64,
    yt: f64,
    tt: f64,
}

impl SecondSums {
    #[inline(always)]
    fn add(&mut self, center: &Center, x: f64, y: f64, theta: f64, weight: f64) {
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

    fn gaussian(&self, center: &Center) -> Gaussian<3> {
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

/// Added to a number and taken off again, it leaves the nearest whole number, whose last bits are
/// those of the sum.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// A quarter turn in two parts, of which the first has few digits: its multiples are exact.
const QUARTER: [f64; 2] = [1.570_796_326_734_125_6, 6.077_100_506_506_192e-11];

/// Sine and cosine of a heading \[rad\], within 2e-15 for headings of a few turns. Without branches
/// and calls, so that several are computed by one instruction.
#[inline(always)]
fn sin_cos(theta: f64) -> (f64, f64) {
    let rounded = theta * FRAC_2_PI + ROUNDER;
    let (quarters, count) = (rounded.to_bits(), rounded - ROUNDER);
    let rest = theta - count * QUARTER[0] - count * QUARTER[1];
    // Both series end below the last digit, as the rest is at most an eighth of a turn.
    let z = rest * rest;
    let sin = rest * series(z, [3.0, 5.0, 7.0, 9.0, 11.0, 13.0, 15.0]);
    let cos = series(z, [2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0]);
    let odd = 0_u64.wrapping_sub(quarters & 1);
    let (s, c) = (sin.to_bits(), cos.to_bits());
    let swap = (s ^ c) & odd;
    let sign = |bits: u64| (bits & 2) << 62;
    let sin = f64::from_bits((s ^ swap) ^ sign(quarters));
    let cos = f64::from_bits((c ^ swap) ^ sign(quarters.wrapping_add(1)));
    (sin, cos)
}

/// `1 - z / (k0 (k0 - 1)) (1 - z / (k1 (k1 - 1)) (..))`: the series of sine over x or cosine.
#[inline(always)]
fn series(z: f64, orders: [f64; 7]) -> f64 {
    orders.iter().rev().fold(1.0, |tail, k| 1.0 - z * (1.0 / (k * (k - 1.0))) * tail)
}

/// An angle without its whole turns \[rad\], in \[-pi, pi\].
#[inline(always)]
fn wrapped(angle: f64) -> f64 {
    angle - TAU * ((angle * (1.0 / TAU) + ROUNDER) - ROUNDER)
}

/// Bound of coordinates \[m\] and headings \[rad\]; numbers beyond it, or NaN, are not a pose.
const MAX_COORDINATE: f64 = 1e9;

/// Number of particles processed together.
const LANES: usize = 8;

/// Coordinates or weights of that many particles.
type Lanes = [f64; LANES];

/// Whether three numbers can be a pose.
#[inline(always)]
fn is_pose(x: f64, y: f64, theta: f64) -> bool {
    (x.abs() < MAX_COORDINATE) & (y.abs() < MAX_COORDINATE) & (theta.abs() < MAX_COORDINATE)
}

/// Sums over particles, several at a time.
trait Sums {
    /// Adds some particles; implementations are inlined into a vectorised loop.
    fn add(&mut self, x: &Lanes, y: &Lanes, theta: &Lanes, weight: &Lanes);
}

/// Adds up particles a few at a time; what is no pose counts as the origin with weight 0, as
/// does the padding at the end.
#[inline(always)]
fn add_all(sums: &mut impl Sums, poses: Poses<'_>, weights: &[f64]) {
    let (xs, last_x) = poses.x.as_chunks::<LANES>();
    let (ys, last_y) = poses.y.as_chunks::<LANES>();
    let (thetas, last_theta) = poses.theta.as_chunks::<LANES>();
    let (whole, last_weight) = weights.as_chunks::<LANES>();
    for (((x, y), theta), weight) in xs.iter().zip(ys).zip(thetas).zip(whole) {
        add_checked(sums, [*x, *y, *theta, *weight]);
    }
    add_checked(sums, [last_x, last_y, last_theta, last_weight].map(filled));
}

#[inline(always)]
fn add_checked(sums: &mut impl Sums, [mut x, mut y, mut theta, mut weight]: [Lanes; 4]) {
    for k in 0..LANES {
        let counts = is_pose(x[k], y[k], theta[k]);
        for value in [&mut x[k], &mut y[k], &mut theta[k], &mut weight[k]] {
            *value = if counts { *value } else { 0.0 };
        }
    }
    sums.add(&x, &y, &theta, &weight);
}

#[inline(always)]
fn filled(rest: &[f64]) -> Lanes {
    let mut lanes = [0.0; LANES];
    lanes[..rest.len()].copy_from_slice(rest);
    lanes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_and_turns_are_those_of_the_standard_library() {
        for k in -20_000..=20_000 {
            let theta = f64::from(k) * 0.001;
            let (sin, cos) = sin_cos(theta);
            assert!((sin - theta.sin()).abs() < 2e-15 && (cos - theta.cos()).abs() < 2e-15);
            assert!((wrapped(theta) - loc_core::angle::wrap(theta)).abs() < 1e-14);
        }
    }
}
