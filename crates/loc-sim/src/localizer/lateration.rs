//! `lateration`: ranges to landmarks over a sliding window, with odometry (D).

use super::driven::DrivenVelocity;
use super::{Estimate, Judgement, Localizer, MethodSettings};
use crate::source::Setup;
use crate::{Error, Result};
use loc_core::Gaussian;
use loc_filters::lateration::{RangeOutcome, SlidingLateration};
use loc_maps::LandmarkMap;
use loc_sensors::event::{Control, Measurement};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

#[derive(Debug)]
pub(super) struct Lateration {
    lateration: SlidingLateration,
    driven: DrivenVelocity,
    /// The estimate before there is any.
    nowhere: Gaussian<3>,
}

impl Lateration {
    pub(super) fn new(setup: &Setup, settings: &MethodSettings) -> Result<Self> {
        if setup.landmarks.is_empty() {
            return Err(Error::Unsuitable {
                method: "lateration".into(),
                expected: "landmarks",
                source_name: setup.name.clone(),
            });
        }
        let map = setup.landmarks.clone();
        let mut lateration = SlidingLateration::new(map, settings.lateration(), setup.start)?;
        if !settings.global {
            lateration = lateration.start_at(&setup.start_belief)?;
        }
        let nowhere = among(&setup.landmarks);
        Ok(Lateration { lateration, driven: DrivenVelocity::default(), nowhere })
    }
}

/// All that is known of a robot of which nothing is: it is somewhere among the landmarks.
pub(super) fn among(landmarks: &LandmarkMap) -> Gaussian<3> {
    let count = landmarks.len().max(1) as f64;
    let places = || landmarks.iter().map(|landmark| landmark.position.xy().coords);
    let middle = places().sum::<nalgebra::Vector2<f64>>() / count;
    let spread = places().map(|place| (place - middle).norm_squared()).sum::<f64>() / count;
    let variances = Vector3::new(spread, spread, PI * PI / 3.0);
    let mean = Vector3::new(middle.x, middle.y, 0.0);
    Gaussian { mean, covariance: Matrix3::from_diagonal(&variances) }
}

impl Localizer for Lateration {
    fn predict(&mut self, stamp: f64, control: &Control) -> Result<()> {
        if let Some((from, twist)) = self.driven.of(stamp, control) {
            self.lateration.velocity(from, twist)?;
        }
        Ok(())
    }

    fn correct(&mut self, stamp: f64, measurement: &Measurement) -> Result<Vec<Judgement>> {
        let Measurement::Landmarks(observations) = measurement else { return Ok(Vec::new()) };
        let outcomes = match self.lateration.ranges(stamp, observations) {
            Ok(outcomes) => outcomes,
            // A measurement beyond the horizon is lost to this method, not to the run.
            Err(loc_filters::Error::TooLate { .. }) => {
                return Ok(vec![Judgement::REFUSED; observations.len()]);
            }
            Err(error) => return Err(error.into()),
        };
        let used = |outcome| matches!(outcome, RangeOutcome::Fits | RangeOutcome::Waiting);
        let judge = |outcome| Judgement { accepted: used(outcome), ..Judgement::REFUSED };
        Ok(outcomes.into_iter().map(judge).collect())
    }

    fn estimate(&self, stamp: f64) -> Result<Estimate> {
        Ok(self.lateration.estimate(stamp)?.unwrap_or(self.nowhere).into())
    }
}
