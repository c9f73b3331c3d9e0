//! A stretch of the drive between two sightings, drawn at once.
//!
//! Odometry speaks far more often than landmarks are seen. The velocities in between are put
//! together to one motion, normally distributed in the frame of its start (E6, E7); a particle then
//! needs one draw for all of them. Where the heading becomes unsure the motion is no longer normal
//! (it bends like a banana), and a new leg begins.

use super::velocities::Hold;
use crate::{Motion, PosesMut};
use loc_core::motion::{Integration, VelocityNoise, dead_reckon};
use loc_core::random::ChaCha8Rng;
use loc_core::{Gaussian, angle};
use nalgebra::{Matrix3, Vector3};
use rand_distr::{Distribution, StandardNormal};

/// Standard deviation of the heading at which a new leg begins \[rad\]. The length of a leg is
/// off by half its square, 0.5 %.
const STRAIGHT: f64 = 0.1;

/// A motion in the frame of its start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Leg {
    motion: Gaussian<3>,
}

impl Leg {
    fn start() -> Self {
        Leg { motion: Gaussian::certain(Vector3::zeros()) }
    }

    fn is_full(&self) -> bool {
        self.motion.covariance.m33 > STRAIGHT * STRAIGHT
    }

    fn is_nothing(&self) -> bool {
        self.motion.mean.amax() <= 0.0 && self.motion.covariance.amax() <= 0.0
    }
}

/// The legs of a drive.
pub(super) fn legs(
    drive: impl IntoIterator<Item = Hold>,
    integration: Integration,
    noise: &VelocityNoise,
) -> Vec<Leg> {
    let (mut legs, mut leg) = (Vec::new(), Leg::start());
    for hold in drive {
        if hold.starts_leg || leg.is_full() {
            legs.push(std::mem::replace(&mut leg, Leg::start()));
        }
        leg.motion = dead_reckon(&leg.motion, hold.twist, hold.duration, integration, noise);
    }
    legs.push(leg);
    legs.retain(|leg| !leg.is_nothing());
    legs
}

impl Motion for Leg {
    fn sample(&self, poses: PosesMut<'_>, rng: &mut ChaCha8Rng) {
        let l = lower_factor(&self.motion.covariance);
        let mean = self.motion.mean;
        let mut draw = || -> f64 { StandardNormal.sample(rng) };
        for ((x, y), theta) in poses.x.iter_mut().zip(poses.y).zip(poses.theta) {
            let step = mean + l * Vector3::from_fn(|_, _| draw());
            let (sin, cos) = theta.sin_cos();
            *x += cos * step.x - sin * step.y;
            *y += sin * step.x + cos * step.y;
            *theta = angle::wrap(*theta + step.z);
        }
    }
}

/// A lower triangular L with `L L^T` = the covariance; a pivot that vanishes leaves its column 0.
fn lower_factor(covariance: &Matrix3<f64>) -> Matrix3<f64> {
    let mut l = Matrix3::zeros();
    for j in 0..3 {
        let pivot = covariance[(j, j)] - (0..j).map(|k| l[(j, k)] * l[(j, k)]).sum::<f64>();
        if pivot <= 1e-14 * covariance[(j, j)] {
            continue;
        }
        l[(j, j)] = pivot.sqrt();
        for i in j + 1..3 {
            let rest = covariance[(i, j)] - (0..j).map(|k| l[(i, k)] * l[(j, k)]).sum::<f64>();
            l[(i, j)] = rest / l[(j, j)];
        }
    }
    l
}
