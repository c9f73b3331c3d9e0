//! Weights from their logarithms, and which particles count at all.

use crate::{Particles, Poses};

/// Farther from the origin than any map reaches \[m\]; what lies beyond, or is not a number, is no
/// pose.
const FARTHEST: f64 = 1e9;

/// How many particles are worked on together.
pub(super) const LANES: usize = 4;

/// Coordinates or weights of that many particles.
pub(super) type Lanes = [f64; LANES];

/// Whether three numbers can be a pose.
#[inline(always)]
pub(super) fn is_pose(x: f64, y: f64, theta: f64) -> bool {
    (x.abs() < FARTHEST) & (y.abs() < FARTHEST) & (theta.abs() < FARTHEST)
}

/// Fills `weights` with the weights of a cloud, the largest of them 1.
///
/// Where none of them is a number above 0 they are all equal, as in [`Particles::normalize`].
pub(super) fn relative_weights(particles: &Particles, weights: &mut Vec<f64>) {
    let log_weights = particles.log_weights();
    weights.clear();
    let [smallest, largest] = extremes(log_weights);
    // After resampling all are equal, and the exponentials can be left out.
    if !largest.is_finite() || smallest >= largest {
        weights.resize(log_weights.len(), 1.0);
    } else {
        // The larger of NaN and 0 is 0.
        weights.extend(log_weights.iter().map(|weight| (weight - largest).exp().max(0.0)));
    }
}

fn extremes(values: &[f64]) -> [f64; 2] {
    let (mut low, mut high) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
    let mut take = |lane: usize, value: f64| {
        low[lane] = if value < low[lane] { value } else { low[lane] };
        high[lane] = if value > high[lane] { value } else { high[lane] };
    };
    let (whole, rest) = values.as_chunks::<LANES>();
    for chunk in whole {
        for (lane, &value) in chunk.iter().enumerate() {
            take(lane, value);
        }
    }
    rest.iter().for_each(|&value| take(0, value));
    [low.into_iter().fold(low[0], f64::min), high.into_iter().fold(high[0], f64::max)]
}

/// Hands out x, y, theta and weight of a few particles at a time; what is no pose comes as the
/// origin with weight 0, and so do the fillers at the end.
#[inline(always)]
pub(super) fn in_lanes(
    poses: Poses<'_>,
    weights: &[f64],
    mut work: impl FnMut(&Lanes, &Lanes, &Lanes, &Lanes),
) {
    let mut checked = |x: &Lanes, y: &Lanes, theta: &Lanes, weight: &Lanes| {
        let (mut x, mut y, mut theta, mut weight) = (*x, *y, *theta, *weight);
        for k in 0..LANES {
            let counts = is_pose(x[k], y[k], theta[k]);
            for value in [&mut x[k], &mut y[k], &mut theta[k], &mut weight[k]] {
                *value = if counts { *value } else { 0.0 };
            }
        }
        work(&x, &y, &theta, &weight);
    };
    let (xs, last_x) = poses.x.as_chunks::<LANES>();
    let (ys, last_y) = poses.y.as_chunks::<LANES>();
    let (thetas, last_theta) = poses.theta.as_chunks::<LANES>();
    let (whole, last_weight) = weights.as_chunks::<LANES>();
    for (((x, y), theta), weight) in xs.iter().zip(ys).zip(thetas).zip(whole) {
        checked(x, y, theta, weight);
    }
    let filled = |rest: &[f64]| -> Lanes {
        std::array::from_fn(|k| rest.get(k).copied().unwrap_or_default())
    };
    checked(&filled(last_x), &filled(last_y), &filled(last_theta), &filled(last_weight));
}
