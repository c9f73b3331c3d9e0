//! The motion since the last update, by the model that the settings name.

use super::MotionSettings;
use crate::motion::{DifferentialStep, DrivenPath, NoisyStep, OmnidirectionalStep};
use crate::{Motion, PosesMut, Result, Transport};
use loc_core::Pose2;
use loc_core::random::ChaCha8Rng;

/// A step of one of the models.
#[derive(Debug)]
pub(super) enum Step {
    Path(NoisyStep),
    Differential(DifferentialStep),
    Omnidirectional(OmnidirectionalStep),
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

impl Motion for Step {
    fn sample(&self, poses: PosesMut<'_>, rng: &mut ChaCha8Rng) {
        match self {
            Step::Path(step) => step.sample(poses, rng),
            Step::Differential(step) => step.sample(poses, rng),
            Step::Omnidirectional(step) => step.sample(poses, rng),
        }
    }
}

impl Transport for Step {
    fn moved(&self, pose: Pose2, noise: [f64; 4]) -> Pose2 {
        match self {
            Step::Path(step) => step.moved(pose, noise),
            Step::Differential(step) => step.moved(pose, noise),
            Step::Omnidirectional(step) => step.moved(pose, noise),
        }
    }
}
