//! The motion since the last update, by the model that the settings name.

use super::MotionSettings;
use crate::motion::{DifferentialStep, DrivenPath, NoisyStep, OmnidirectionalStep, PathNoise};
use crate::{Motion, PosesMut, Result, Transport};
use loc_core::random::ChaCha8Rng;
use loc_core::{Gaussian, Pose2};
use nalgebra::{Matrix3, Vector3};
use rand_distr::{Distribution, StandardNormal};

/// A step of one of the models.
#[derive(Debug)]
pub(super) enum Step {
    Path(NoisyStep),
    Differential(DifferentialStep),
    Omnidirectional(OmnidirectionalStep),
    /// From the belief about the start, whatever pose a particle had: mean, and a factor of the
    /// covariance.
    Start(Vector3<f64>, Matrix3<f64>),
}

impl Step {
    pub(super) fn new(path: &DrivenPath, settings: &MotionSettings) -> Result<Self> {
        let (from, to) = (path.start(), path.end());
        Ok(match settings {
            MotionSettings::Path(noise) => Step::Path(NoisyStep::new(path, noise)),
            MotionSettings::Differential(noise) => {
                Step::Differential(DifferentialStep::between(from, to, noise)?)
            }
            MotionSettings::Omnidirectional(noise) => {
                Step::Omnidirectional(OmnidirectionalStep::between(from, to, noise)?)
            }
        })
    }
}

impl Step {
    /// The way from the start belief to the first scan; its covariance was checked at the start.
    pub(super) fn from_start(path: &DrivenPath, belief: &Gaussian<3>, noise: &PathNoise) -> Self {
        let belief = noise.belief_after(path, belief);
        Step::Start(belief.mean, belief.factor())
    }
}

impl Motion for Step {
    fn sample(&self, poses: PosesMut<'_>, rng: &mut ChaCha8Rng) {
        let one_by_one = |pose, rng: &mut ChaCha8Rng| {
            self.moved(pose, std::array::from_fn(|_| StandardNormal.sample(rng)))
        };
        match self {
            Step::Path(step) => step.sample(poses, rng),
            Step::Differential(step) => step.sample(poses, rng),
            Step::Omnidirectional(step) => step.sample(poses, rng),
            Step::Start(..) => one_by_one.sample(poses, rng),
        }
    }
}

impl Transport for Step {
    fn moved(&self, pose: Pose2, noise: [f64; 4]) -> Pose2 {
        match self {
            Step::Path(step) => step.moved(pose, noise),
            Step::Differential(step) => step.moved(pose, noise),
            Step::Omnidirectional(step) => step.moved(pose, noise),
            Step::Start(mean, factor) => {
                let [a, b, c, _] = noise;
                Pose2::from_vector(&(mean + factor * Vector3::new(a, b, c)))
            }
        }
    }
}
