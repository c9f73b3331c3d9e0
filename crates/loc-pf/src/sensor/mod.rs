//! Sensor models: how likely a measurement is at each of many poses.
//!
//! A model takes a measurement once and then rates poses; what can be computed from the
//! measurement alone is computed once. Anything that rates a pose is a [`Likelihood`], also a
//! closure.

pub mod beam;
pub mod landmark;
pub mod likelihood_field;
pub mod perceptual;

pub use beam::{BeamLikelihood, BeamModel, BeamModelSettings};
pub use landmark::LandmarkLikelihood;
pub use likelihood_field::{BeamSkip, FieldLikelihood, SumOfCubes};

use crate::Poses;
use loc_core::Pose2;

/// A measurement, prepared to rate poses.
///
/// Several threads rate different particles at the same time; the rating of a particle must not
/// depend on which others it comes with.
pub trait Likelihood: Sync {
    /// Adds `ln p(measurement | pose)` to the logarithm beside each pose. What is added is never
    /// NaN; -inf excludes a pose.
    fn rate(&self, poses: Poses<'_>, log_weights: &mut [f64]);
}

impl<F: Fn(Pose2) -> f64 + Sync> Likelihood for F {
    fn rate(&self, poses: Poses<'_>, log_weights: &mut [f64]) {
        for (pose, weight) in poses.iter().zip(log_weights) {
            *weight += self(pose);
        }
    }
}
