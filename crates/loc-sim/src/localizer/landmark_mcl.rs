//! `mcl` among landmarks: Monte Carlo localization by sightings (M5).

use super::driven::DrivenVelocity;
use super::{Cloud, Estimate, Judgement, Localizer, MethodSettings, seen_at};
use crate::Result;
use crate::event::{Control, Measurement};
use crate::source::Setup;
use loc_core::Pose2;
use loc_core::random::stream;
use loc_pf::LandmarkMcl;
use loc_pf::landmark_mcl::SightingUpdate;
use loc_sensors::landmark_camera::Sighting;

/// Below this probability a sighting counts as turned away.
const BELIEVED: f64 = 0.5;

#[derive(Debug)]
pub(super) struct SightMcl {
    mcl: LandmarkMcl,
    mounting: Pose2,
    driven: DrivenVelocity,
}

impl SightMcl {
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
        Ok(SightMcl { mcl, mounting, driven: DrivenVelocity::default() })
    }

    fn judge(&self, pose: Pose2, update: &SightingUpdate, sighting: &Sighting) -> Judgement {
        let trust = update.trust.iter().find(|trust| trust.sighting == *sighting);
        Judgement {
            accepted: trust.is_some_and(|trust| trust.probability >= BELIEVED),
            seen_at: seen_at(pose * self.mounting, sighting),
            ..Judgement::REFUSED
        }
    }
}

impl Localizer for SightMcl {
    fn predict(&mut self, stamp: f64, control: &Control) -> Result<()> {
        if let Some((from, twist)) = self.driven.of(stamp, control) {
            self.mcl.velocity(from, twist)?;
        }
        Ok(())
    }

    fn correct(&mut self, stamp: f64, measurement: &Measurement) -> Result<Vec<Judgement>> {
        let Measurement::Landmarks(sightings) = measurement else { return Ok(Vec::new()) };
        let update = match self.mcl.sightings(stamp, sightings) {
            Ok(update) => update,
            // A measurement beyond the horizon is lost to this method, not to the run.
            Err(loc_pf::Error::TooLate { .. }) => {
                return Ok(vec![Judgement::REFUSED; sightings.len()]);
            }
            Err(error) => return Err(error.into()),
        };
        let pose = self.mcl.estimate(stamp)?.pose();
        Ok(sightings.iter().map(|sighting| self.judge(pose, &update, sighting)).collect())
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
