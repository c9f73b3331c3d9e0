//! `mcl` among landmarks: Monte Carlo localization by observations (M5).

use super::driven::DrivenVelocity;
use super::{Cloud, Estimate, Judgement, Localizer, MethodSettings, seen_at};
use crate::Result;
use crate::source::Setup;
use loc_core::Pose2;
use loc_core::random::stream;
use loc_pf::LandmarkMcl;
use loc_pf::landmark_mcl::ObservationUpdate;
use loc_sensors::event::{Control, Measurement};
use loc_sensors::landmark_camera::LandmarkObservation;

/// Below this probability an observation counts as turned away.
const BELIEVED: f64 = 0.5;

#[derive(Debug)]
pub(super) struct ObservationMcl {
    mcl: LandmarkMcl,
    mounting: Pose2,
    driven: DrivenVelocity,
}

impl ObservationMcl {
    /// The caller has made sure that there are landmarks.
    pub(super) fn new(setup: &Setup, settings: &MethodSettings) -> Result<Self> {
        let (map, rng) = (setup.landmarks.clone(), stream(settings.seed, "mcl"));
        let with = settings.landmark_mcl();
        let mcl = if settings.global {
            LandmarkMcl::anywhere(map, with, setup.start, rng)?
        } else {
            LandmarkMcl::new(map, with, setup.start, &setup.start_belief, rng)?
        };
        let mounting = with.sights.mounting;
        Ok(ObservationMcl { mcl, mounting, driven: DrivenVelocity::default() })
    }

    fn judge(
        &self,
        pose: Pose2,
        update: &ObservationUpdate,
        observation: &LandmarkObservation,
    ) -> Judgement {
        let trust = update.trust.iter().find(|trust| trust.observation == *observation);
        Judgement {
            accepted: trust.is_some_and(|trust| trust.probability >= BELIEVED),
            seen_at: seen_at(pose * self.mounting, observation),
            ..Judgement::REFUSED
        }
    }
}

impl Localizer for ObservationMcl {
    fn predict(&mut self, stamp: f64, control: &Control) -> Result<()> {
        if let Some((from, twist)) = self.driven.of(stamp, control) {
            self.mcl.velocity(from, twist)?;
        }
        Ok(())
    }

    fn correct(&mut self, stamp: f64, measurement: &Measurement) -> Result<Vec<Judgement>> {
        let Measurement::Landmarks(observations) = measurement else { return Ok(Vec::new()) };
        let update = match self.mcl.observations(stamp, observations) {
            Ok(update) => update,
            // A measurement beyond the horizon is lost to this method, not to the run.
            Err(loc_pf::Error::TooLate { .. }) => {
                return Ok(vec![Judgement::REFUSED; observations.len()]);
            }
            Err(error) => return Err(error.into()),
        };
        let pose = self.mcl.estimate(stamp)?.pose();
        Ok(observations.iter().map(|observation| self.judge(pose, &update, observation)).collect())
    }

    fn estimate(&self, stamp: f64) -> Result<Estimate> {
        Ok(self.mcl.estimate(stamp)?.into())
    }

    fn particle_count(&self) -> usize {
        self.mcl.particles().len()
    }

    fn cloud(&self) -> Option<Cloud> {
        let cloud = Cloud::of(self.mcl.particles());
        Some(match self.mcl.weighed() {
            Some(weighed) => cloud.with_weighed(weighed),
            None => cloud,
        })
    }
}
