//! `fastslam`: particles that each draw a map of landmarks while the robot drives (I2 to I4).

use super::driven::DrivenVelocity;
use super::ekf_slam::judge;
use super::{Cloud, Estimate, EstimatedMap, Judgement, Localizer, MethodSettings};
use crate::Result;
use crate::source::Setup;
use loc_core::Pose2;
use loc_core::random::stream;
use loc_filters::slam::Identities;
use loc_pf::FastSlamLocalizer;
use loc_sensors::event::{Control, Measurement};

/// It is told where it starts, and nothing of the landmarks.
#[derive(Debug)]
pub(super) struct FastSlamMethod {
    localizer: FastSlamLocalizer,
    mounting: Pose2,
    numbered: bool,
    driven: DrivenVelocity,
}

impl FastSlamMethod {
    pub(super) fn new(setup: &Setup, settings: &MethodSettings) -> Result<Self> {
        let (slam, horizon) = (settings.fastslam(), settings.landmark.horizon);
        let rng = stream(settings.seed, "fastslam");
        let start = setup.start_belief;
        Ok(FastSlamMethod {
            localizer: FastSlamLocalizer::new(slam, setup.start, start, horizon, rng)?,
            mounting: slam.mounting,
            numbered: slam.identities == Identities::Known,
            driven: DrivenVelocity::default(),
        })
    }
}

impl Localizer for FastSlamMethod {
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
            Err(loc_pf::Error::Filter(loc_filters::Error::TooLate { .. })) => {
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

    fn particle_count(&self) -> usize {
        self.localizer.newest().settings().particles
    }

    fn map(&self) -> Result<Option<EstimatedMap>> {
        let landmarks = self.localizer.landmarks()?;
        Ok(Some(EstimatedMap { numbered: self.numbered, landmarks }))
    }

    fn cloud(&self) -> Option<Cloud> {
        Some(Cloud::of(&self.localizer.particles()))
    }
}
