//! The landmark filter on time-stamped inputs.

use super::LandmarkFilter;
use crate::delayed::{Clock, Sequential};
use crate::divergence::{DivergenceMonitor, gap};
use crate::localizer::{Estimate, Localizer, Outcome, observed_position};
use crate::smoother::{Recorded, Smoothable};
use crate::{ExtendedKalmanFilter, NonlinearFilter, Result, RobotSettings};
use loc_core::{Gaussian, Twist2};
use loc_maps::LandmarkMap;
use loc_sensors::event::{Control, Measurement, Payload};
use std::sync::Arc;

/// Landmark localization over time-stamped inputs in order; [`Delayed`](crate::delayed::Delayed)
/// around it takes late ones.
///
/// A velocity holds from its stamp until the next one. Observations may come between velocities,
/// several at one stamp, or not at all. The filter is the extended Kalman filter, unless another one
/// is named.
#[derive(Debug, Clone)]
pub struct LandmarkLocalizer<F: NonlinearFilter<3> = ExtendedKalmanFilter<3>> {
    filter: LandmarkFilter<F>,
    map: Arc<LandmarkMap>,
    clock: Clock,
    twist: Twist2,
    divergence: DivergenceMonitor,
    /// When the filter had diverged last \[s\].
    diverged_at: f64,
}

impl LandmarkLocalizer {
    /// A localizer with the extended Kalman filter that stands still at `stamp` \[s\] with a belief
    /// over (x, y, theta).
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief, a stamp or settings that are not valid.
    pub fn new(
        map: impl Into<Arc<LandmarkMap>>,
        settings: RobotSettings,
        stamp: f64,
        start: Gaussian<3>,
    ) -> Result<Self> {
        LandmarkLocalizer::with_filter(map, settings, stamp, start)
    }
}

impl<F: NonlinearFilter<3>> LandmarkLocalizer<F> {
    /// A localizer with any filter.
    ///
    /// # Errors
    /// As [`LandmarkLocalizer::new`].
    pub fn with_filter(
        map: impl Into<Arc<LandmarkMap>>,
        settings: RobotSettings,
        stamp: f64,
        start: Gaussian<3>,
    ) -> Result<Self> {
        let clock = Clock::starting_at(stamp)?;
        let filter = LandmarkFilter::new(start, settings)?;
        let divergence = DivergenceMonitor::default();
        let (map, twist) = (map.into(), Twist2::ZERO);
        Ok(LandmarkLocalizer { filter, map, clock, twist, divergence, diverged_at: stamp })
    }

    fn predict_to(&mut self, what: &'static str, stamp: f64) -> Result<()> {
        let dt = self.clock.advance(what, stamp)?;
        self.filter.predict(self.twist, dt)
    }
}

impl<F: NonlinearFilter<3>> Localizer for LandmarkLocalizer<F> {
    fn predict(&mut self, stamp: f64, control: &Control) -> Result<()> {
        let Control::Velocity(twist) = control else { return Ok(()) };
        crate::innovation::finite("velocity", &twist.to_vector())?;
        self.predict_to("velocity", stamp)?;
        self.twist = *twist;
        Ok(())
    }

    fn correct(&mut self, stamp: f64, measurement: &Measurement) -> Result<Vec<Outcome>> {
        let Measurement::Landmarks(observations) = measurement else { return Ok(Vec::new()) };
        for observation in observations {
            observation.observed.check()?;
        }
        self.predict_to("observations", stamp)?;
        let mut outcomes = Vec::with_capacity(observations.len());
        for observation in observations {
            let outcome = self.filter.correct(&self.map, observation)?;
            let is_gated = outcome.nis.is_some();
            outcomes.push(outcome);
            if is_gated && self.divergence.observe(outcome.accepted()) {
                self.diverged_at = stamp;
                let camera = self.filter.belief().pose() * self.filter.settings().mounting;
                self.filter.widen_by(gap(&self.map, camera, observations))?;
            }
        }
        let camera = self.filter.belief().pose() * self.filter.settings().mounting;
        for (outcome, observation) in outcomes.iter_mut().zip(observations) {
            outcome.observed_at = observed_position(camera, observation);
        }
        Ok(outcomes)
    }

    fn estimate(&self, stamp: f64) -> Result<Estimate> {
        let mut filter = self.filter.clone();
        filter
            .predict(self.twist, self.clock.until(loc_core::error::finite("stamp [s]", stamp)?))?;
        Ok((*filter.belief()).into())
    }

    fn notes(&self) -> Vec<String> {
        self.divergence.notes(self.diverged_at)
    }
}

impl<F: NonlinearFilter<3>> Sequential for LandmarkLocalizer<F> {
    fn uses(&self, measurement: &Measurement) -> bool {
        matches!(measurement, Measurement::Landmarks(_))
    }

    fn rank(_input: &Payload) -> u64 {
        0
    }

    fn mark(&mut self, stamp: f64) -> Result<()> {
        self.predict_to("mark", stamp)?;
        self.filter.mark();
        Ok(())
    }
}

impl<F: NonlinearFilter<3>> LandmarkLocalizer<Recorded<F, 3>> {
    /// What the filter believed at each mark.
    pub fn filtered(&self) -> Vec<Estimate> {
        let beliefs = self.filter.filter().past().filtered_marked();
        beliefs.into_iter().map(Estimate::from).collect()
    }
}

impl<F: NonlinearFilter<3>> Smoothable for LandmarkLocalizer<Recorded<F, 3>> {
    fn smoothed(&self) -> Result<Vec<Estimate>> {
        let beliefs = self.filter.filter().past().smooth_marked()?;
        Ok(beliefs.into_iter().map(Estimate::from).collect())
    }
}
