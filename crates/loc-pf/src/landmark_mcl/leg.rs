//! A stretch of the drive between two observations, drawn at once.
//!
//! Odometry speaks far more often than landmarks are seen. The velocities in between are put
//! together to one motion, normally distributed in the frame of its start (E6, E7); a particle then
//! needs one draw for all of them. Where the heading becomes unsure the motion is no longer normal
//! (it bends like a banana), and a new leg begins.

use super::velocities::Hold;
use crate::Result;
use crate::motion::VelocityStep;
use loc_core::Gaussian;
use loc_core::motion::{Integration, Twist2, VelocityNoise, dead_reckon};
use nalgebra::Vector3;

/// Standard deviation of the heading at which a new leg begins \[rad\]. The length of a leg is
/// off by half its square, 0.5 %.
const STRAIGHT: f64 = 0.1;

/// The legs of a drive, each a step along and across the heading at its start.
///
/// # Errors
/// [`loc_core::Error::OutOfRange`] where the drive is longer than any robot's.
pub(super) fn legs(
    drive: impl IntoIterator<Item = Hold>,
    integration: Integration,
    noise: &VelocityNoise,
) -> Result<Vec<VelocityStep>> {
    let start = Gaussian::certain(Vector3::zeros());
    let (mut legs, mut leg) = (Vec::new(), start);
    for hold in drive {
        if hold.starts_leg || leg.covariance.m33 > STRAIGHT * STRAIGHT {
            legs.push(std::mem::replace(&mut leg, start));
        }
        leg = dead_reckon(&leg, hold.twist, hold.duration, integration, noise);
    }
    legs.push(leg);
    legs.retain(|leg| *leg != start);
    legs.iter().map(step).collect()
}

/// Euler's rule over a time of 1 s takes a velocity for a displacement.
fn step(leg: &Gaussian<3>) -> Result<VelocityStep> {
    let displacement = Twist2::from_vector(&leg.mean);
    VelocityStep::with_covariance(displacement, 1.0, &leg.covariance, Integration::Euler)
}
