//! `dead-reckoning`: odometry alone, with its growing covariance (E2, E6).

use super::{Estimate, Judgement, Localizer};
use crate::Result;
use crate::event::{Control, Measurement};
use loc_filters::landmark::{LandmarkLocalizer, LandmarkSettings};
use loc_maps::LandmarkMap;

use crate::source::Setup;

/// The prediction step of the landmark filter, without its corrections.
#[derive(Debug)]
pub(super) struct DeadReckoning(LandmarkLocalizer);

impl DeadReckoning {
    pub(super) fn new(setup: &Setup, settings: LandmarkSettings) -> Result<Self> {
        let none = LandmarkMap::default();
        Ok(DeadReckoning(LandmarkLocalizer::new(none, settings, setup.start, setup.start_belief)?))
    }
}

impl Localizer for DeadReckoning {
    fn predict(&mut self, stamp: f64, control: &Control) -> Result<()> {
        if let Control::Velocity(twist) = control {
            self.0.velocity(stamp, *twist)?;
        }
        Ok(())
    }

    fn correct(&mut self, _stamp: f64, _measurement: &Measurement) -> Result<Vec<Judgement>> {
        Ok(Vec::new())
    }

    fn estimate(&self, stamp: f64) -> Result<Estimate> {
        Ok(self.0.estimate(stamp)?.into())
    }
}
