//! What all models share: many poses moved in one vectorised loop.

use crate::elementary::{sin_cos, wrap};
use crate::normals::{BLOCK, Normals};
use crate::{PosesMut, Result};
use loc_core::Pose2;
use loc_core::error::in_range;
use loc_core::random::ChaCha8Rng;
use pulp::{Arch, Simd, WithSimd};

/// A displacement in a frame that is turned against the robot's.
#[derive(Debug, Clone, Copy)]
pub(super) struct Displacement {
    /// How far the frame is turned against the robot's heading before the step \[rad\].
    pub(super) direction: f64,
    /// Way in that direction \[m\].
    pub(super) along: f64,
    /// Way at a right angle to it, to the left \[m\].
    pub(super) across: f64,
    /// Change of the heading \[rad\].
    pub(super) turn: f64,
}

/// One drawn step, from three independent standard normal numbers.
///
/// Implementations are inlined into the vectorised loop and must not branch.
pub(super) trait Step: Copy {
    fn draw(self, noise: [f64; 3]) -> Displacement;
}

/// One pose moved by the step that given numbers stand for.
pub(super) fn moved<S: Step>(step: S, pose: Pose2, noise: [f64; 4]) -> Pose2 {
    let [first, second, third, _] = noise;
    let Displacement { direction, along, across, turn } = step.draw([first, second, third]);
    let (sin, cos) = (pose.theta + direction).sin_cos();
    Pose2::new(
        pose.x + along * cos - across * sin,
        pose.y + along * sin + across * cos,
        pose.theta + turn,
    )
}

/// Moves every pose by a drawn step.
pub(super) fn move_all<S: Step>(step: S, poses: PosesMut<'_>, rng: &mut ChaCha8Rng) {
    let normals = Normals::from_rng(rng);
    Arch::new().dispatch(MoveAll { step, poses, normals });
}

struct MoveAll<'a, S> {
    step: S,
    poses: PosesMut<'a>,
    normals: Normals,
}

impl<S: Step> WithSimd for MoveAll<'_, S> {
    type Output = ();

    #[inline(always)]
    fn with_simd<V: Simd>(mut self, _: V) {
        let PosesMut { x, y, theta } = self.poses;
        let blocks = x.chunks_mut(BLOCK).zip(y.chunks_mut(BLOCK)).zip(theta.chunks_mut(BLOCK));
        for ((x, y), theta) in blocks {
            let noise = [self.normals.block(), self.normals.block(), self.normals.block()];
            move_block(self.step, [x, y, theta], &noise);
        }
    }
}

#[inline(always)]
fn move_block<S: Step>(step: S, [x, y, theta]: [&mut [f64]; 3], noise: &[[f32; BLOCK]; 3]) {
    let poses = x.iter_mut().zip(y).zip(theta);
    let noise = noise[0].iter().zip(&noise[1]).zip(&noise[2]);
    for (((x, y), theta), ((&a, &b), &c)) in poses.zip(noise) {
        let drawn = step.draw([f64::from(a), f64::from(b), f64::from(c)]);
        let (sin, cos) = sin_cos(*theta + drawn.direction);
        *x += drawn.along * cos - drawn.across * sin;
        *y += drawn.along * sin + drawn.across * cos;
        *theta = wrap(*theta + drawn.turn);
    }
}

/// A standard deviation of an angle, bounded: beyond a few turns every direction is as likely, and
/// larger angles would lose digits.
pub(super) fn angle_sigma(variance: f64) -> f64 {
    variance.sqrt().min(1e3)
}

/// The standard deviation of a way \[m\], bounded too: no coordinate overflows.
pub(super) fn way_sigma(variance: f64) -> f64 {
    variance.sqrt().min(FURTHEST)
}

/// Checks that a way \[m\] or a turn \[rad\] is one that a robot can make.
pub(super) fn bounded(what: &'static str, value: f64) -> Result<f64> {
    Ok(in_range(what, "a number in [-1e9, 1e9]", value, |value| value.abs() <= FURTHEST)?)
}

/// No robot moves further in one step \[m\].
const FURTHEST: f64 = 1e9;
