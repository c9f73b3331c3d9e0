//! `ekf` and `ukf`: the extended (H2) and the unscented Kalman filter with landmarks.

use super::driven::DrivenVelocity;
use super::{Estimate, Judgement, Localizer, MethodSettings, Whitened, seen_at};
use crate::source::Setup;
use crate::{Error, Result};
use loc_core::Pose2;
use loc_filters::NonlinearFilter;
use loc_filters::landmark::{LandmarkLocalizer, Outcome, Verdict};
use loc_sensors::event::{Control, Measurement};
use loc_sensors::landmark_camera::LandmarkObservation;

#[derive(Debug)]
pub(super) struct Ekf<F: NonlinearFilter<3>> {
    localizer: LandmarkLocalizer<F>,
    mounting: Pose2,
    driven: DrivenVelocity,
}

impl<F: NonlinearFilter<3>> Ekf<F> {
    pub(super) fn new(method: &str, setup: &Setup, settings: &MethodSettings) -> Result<Self> {
        let settings = settings.landmark;
        if setup.landmarks.is_empty() {
            return Err(Error::Unsuitable {
                method: method.into(),
                expected: "landmarks",
                source_name: setup.name.clone(),
            });
        }
        let map = setup.landmarks.clone();
        let (start, belief) = (setup.start, setup.start_belief);
        let localizer = LandmarkLocalizer::with_filter(map, settings, start, belief)?;
        let mounting = settings.mounting;
        Ok(Ekf { localizer, mounting, driven: DrivenVelocity::default() })
    }

    fn judge(
        &self,
        pose: Pose2,
        outcome: &Outcome,
        observation: &LandmarkObservation,
    ) -> Judgement {
        Judgement {
            accepted: outcome.accepted(),
            nis: outcome.nis(),
            degrees_of_freedom: outcome.degrees_of_freedom(),
            whitened: whitened(outcome),
            seen_at: seen_at(pose * self.mounting, observation),
        }
    }
}

impl<F: NonlinearFilter<3>> Localizer for Ekf<F> {
    fn predict(&mut self, stamp: f64, control: &Control) -> Result<()> {
        if let Some((from, twist)) = self.driven.of(stamp, control) {
            self.localizer.velocity(from, twist)?;
        }
        Ok(())
    }

    fn correct(&mut self, stamp: f64, measurement: &Measurement) -> Result<Vec<Judgement>> {
        let Measurement::Landmarks(observations) = measurement else { return Ok(Vec::new()) };
        let outcomes = match self.localizer.observations(stamp, observations) {
            Ok(outcomes) => outcomes,
            // A measurement beyond the horizon is lost to this method, not to the run.
            Err(loc_filters::Error::TooLate { .. }) => {
                return Ok(vec![Judgement::REFUSED; observations.len()]);
            }
            Err(error) => return Err(error.into()),
        };
        let pose = self.localizer.estimate(stamp)?.pose();
        let pairs = outcomes.iter().zip(observations);
        Ok(pairs.map(|(outcome, observation)| self.judge(pose, outcome, observation)).collect())
    }

    fn estimate(&self, stamp: f64) -> Result<Estimate> {
        Ok(self.localizer.estimate(stamp)?.into())
    }
}

fn whitened(outcome: &Outcome) -> Whitened {
    match &outcome.verdict {
        Verdict::UnknownLandmark => Whitened::NONE,
        Verdict::RangeBearing(innovation) => innovation.whitened.into(),
        Verdict::Range(innovation) | Verdict::Bearing(innovation) => innovation.whitened.into(),
    }
}
