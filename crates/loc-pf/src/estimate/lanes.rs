//! Which particles count at all, and several of them at a time.

use crate::Poses;

/// Farther from the origin than any map reaches \[m\]; what lies beyond, or is not a number, is no
/// pose.
const FARTHEST: f64 = 1e9;

/// How many particles are worked on together.
pub(super) const LANES: usize = 8;

/// Coordinates or weights of that many particles.
pub(super) type Lanes = [f64; LANES];

/// Whether three numbers can be a pose.
#[inline(always)]
pub(super) fn is_pose(x: f64, y: f64, theta: f64) -> bool {
    (x.abs() < FARTHEST) & (y.abs() < FARTHEST) & (theta.abs() < FARTHEST)
}

/// What is added up over particles, several at a time.
pub(super) trait Sums {
    /// Takes in some particles; implementations are inlined into a vectorised loop.
    fn add(&mut self, x: &Lanes, y: &Lanes, theta: &Lanes, weight: &Lanes);
}

/// Adds up particles a few at a time; what is no pose counts as the origin with weight 0, and so do
/// the fillers at the end.
#[inline(always)]
pub(super) fn add_all(sums: &mut impl Sums, poses: Poses<'_>, weights: &[f64]) {
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
