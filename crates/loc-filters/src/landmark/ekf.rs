//! The landmark EKF, as the lecture page has it (H2).

use super::{
    BearingModel, LandmarkSettings, Outcome, RangeBearingModel, RangeModel, VelocityMotion, Verdict,
};
use crate::{Error, ExtendedKalmanFilter, Gate, NonlinearFilter, Result, UnscentedKalmanFilter};
use loc_core::{Gaussian, Twist2};
use loc_maps::LandmarkMap;
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use nalgebra::{Vector1, Vector2};

/// A Kalman filter over (x, y, theta) \[m, m, rad\] with known landmarks: [`LandmarkEkf`] or
/// [`LandmarkUkf`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LandmarkFilter<F> {
    filter: F,
    settings: LandmarkSettings,
    gate: Gate,
}

/// The extended Kalman filter (H2).
pub type LandmarkEkf = LandmarkFilter<ExtendedKalmanFilter<3>>;

/// The unscented Kalman filter on the same models.
pub type LandmarkUkf = LandmarkFilter<UnscentedKalmanFilter<3>>;

impl<F: NonlinearFilter<3>> LandmarkFilter<F> {
    /// A filter that starts from a belief over (x, y, theta).
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief or settings that are not valid.
    pub fn new(start: Gaussian<3>, settings: LandmarkSettings) -> Result<Self> {
        let gate = settings.gate()?;
        let filter = F::start(start, &[2])?;
        Ok(LandmarkFilter { filter, settings, gate })
    }

    /// What the filter believes now.
    pub fn belief(&self) -> &Gaussian<3> {
        self.filter.belief()
    }

    /// Drives on with velocity `twist` for `dt` \[s\].
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the velocity, [`loc_core::Error::OutOfRange`] for a negative time.
    pub fn predict(&mut self, twist: Twist2, dt: f64) -> Result<()> {
        crate::innovation::finite("velocity", &twist.to_vector())?;
        loc_core::error::non_negative("time step [s]", dt)?;
        let LandmarkSettings { integration, motion_noise: noise, .. } = self.settings;
        self.filter.predict(&VelocityMotion { twist, dt, integration, noise })
    }

    /// The filter on the models of this module.
    pub(super) fn filter(&self) -> &F {
        &self.filter
    }

    /// See [`NonlinearFilter::mark`].
    pub(super) fn mark(&mut self) {
        self.filter.mark();
    }

    /// Corrects with one observation. Several of one moment are given one after the other; each is
    /// then linearised where the one before has led, and gated for itself.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for an observation that is not finite or has a negative range.
    pub fn correct(
        &mut self,
        map: &LandmarkMap,
        observation: &LandmarkObservation,
    ) -> Result<Outcome> {
        let sight = observation.sight.check()?;
        let verdict = match map.get(observation.landmark) {
            None => Verdict::UnknownLandmark,
            Some(landmark) => {
                let LandmarkSettings { mounting, observation_noise: noise, .. } = self.settings;
                let landmark = landmark.position.xy();
                self.judge(sight, RangeBearingModel { landmark, mounting, noise })?
            }
        };
        Ok(Outcome { landmark: observation.landmark, verdict })
    }

    fn judge(&mut self, sight: Observed, model: RangeBearingModel) -> Result<Verdict, Error> {
        let (filter, gate) = (&mut self.filter, &self.gate);
        Ok(match sight {
            Observed::RangeBearing { range, bearing } => {
                let z = Vector2::new(range, bearing);
                Verdict::RangeBearing(filter.correct(&model, &z, gate)?)
            }
            Observed::Range { range } => {
                Verdict::Range(filter.correct(&RangeModel(model), &Vector1::new(range), gate)?)
            }
            Observed::Bearing { bearing } => Verdict::Bearing(filter.correct(
                &BearingModel(model),
                &Vector1::new(bearing),
                gate,
            )?),
        })
    }
}
