//! `ekf-slam`: the robot draws its map of landmarks while it drives (I2 to I4).

use super::driven::DrivenVelocity;
use super::{Estimate, EstimatedMap, Judgement, Localizer, MethodSettings, Whitened, seen_at};
use crate::Result;
use crate::source::Setup;
use loc_core::Pose2;
use loc_filters::slam::{Identities, SlamLocalizer, SlamOutcome, SlamVerdict};
use loc_sensors::event::{Control, Measurement};
use loc_sensors::landmark_camera::LandmarkObservation;

/// It is told where it starts, and nothing of the landmarks.
#[derive(Debug)]
pub(super) struct EkfSlamMethod {
    localizer: SlamLocalizer,
    mounting: Pose2,
    numbered: bool,
    driven: DrivenVelocity,
}

impl EkfSlamMethod {
    pub(super) fn new(setup: &Setup, settings: &MethodSettings) -> Result<Self> {
        let (slam, horizon) = (settings.slam(), settings.landmark.horizon);
        Ok(EkfSlamMethod {
            localizer: SlamLocalizer::new(slam, setup.start, setup.start_belief, horizon)?,
            mounting: slam.mounting,
            numbered: slam.identities == Identities::Known,
            driven: DrivenVelocity::default(),
        })
    }
}

impl Localizer for EkfSlamMethod {
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
        let camera = self.localizer.estimate(stamp)?.pose() * self.mounting;
        let pairs = outcomes.iter().zip(observations);
        Ok(pairs.map(|(outcome, observation)| judge(camera, outcome, observation)).collect())
    }

    fn estimate(&self, stamp: f64) -> Result<Estimate> {
        Ok(self.localizer.estimate(stamp)?.into())
    }

    fn map(&self) -> Result<Option<EstimatedMap>> {
        let landmarks = self.localizer.landmarks()?;
        Ok(Some(EstimatedMap { numbered: self.numbered, landmarks }))
    }
}

/// What became of an observation from a camera's pose.
pub(super) fn judge(
    camera: Pose2,
    outcome: &SlamOutcome,
    observation: &LandmarkObservation,
) -> Judgement {
    Judgement {
        accepted: outcome.accepted(),
        nis: outcome.nis(),
        degrees_of_freedom: outcome.degrees_of_freedom(),
        whitened: whitened(outcome),
        seen_at: seen_at(camera, observation),
    }
}

fn whitened(outcome: &SlamOutcome) -> Whitened {
    match &outcome.verdict {
        SlamVerdict::RangeBearing(innovation) => innovation.whitened.into(),
        SlamVerdict::Range(innovation) | SlamVerdict::Bearing(innovation) => {
            innovation.whitened.into()
        }
        _ => Whitened::NONE,
    }
}
