//! Filters that record their past for smoothing.

use super::{Link, Recordable, Smoother};
use crate::delayed::{OdometryVelocity, Sequential, apply};
use crate::kalman::{LinearMeasurement, LinearMotion};
use crate::localizer::Estimate;
use crate::{
    Gate, Innovation, KalmanFilter, MeasurementModel, MotionModel, NonlinearFilter, Result,
};
use loc_core::Gaussian;
use loc_sensors::event::{Control, Event, Payload};
use nalgebra::SVector;

/// A filter that is run as always and keeps what smoothing needs. Around a
/// [`NonlinearFilter`] it is one itself, so that whatever runs on such a filter can be smoothed. A
/// copy of the past is cheap.
#[derive(Debug, Clone)]
pub struct Recorded<F, const N: usize> {
    filter: F,
    past: Smoother<N>,
}

impl<const N: usize> Recordable<N> for KalmanFilter<N> {
    fn belief(&self) -> &Gaussian<N> {
        self.belief()
    }
    fn angles(&self) -> &'static [usize] {
        &[]
    }
}

impl<F: Recordable<N>, const N: usize> Recorded<F, N> {
    /// A filter whose past begins now.
    pub fn new(filter: F) -> Self {
        Recorded { past: Smoother::begin(*filter.belief(), filter.angles()), filter }
    }

    /// The filter as it is now.
    pub fn filter(&self) -> &F {
        &self.filter
    }

    /// The current belief.
    pub fn belief(&self) -> &Gaussian<N> {
        self.filter.belief()
    }

    /// Its past, ready to be smoothed.
    pub fn past(&self) -> &Smoother<N> {
        &self.past
    }
}

impl<const N: usize> Recorded<KalmanFilter<N>, N> {
    /// See [`KalmanFilter::predict`].
    ///
    /// # Errors
    /// Those of the filter; nothing is then recorded.
    pub fn predict<const U: usize>(
        &mut self,
        motion: &LinearMotion<N, U>,
        u: &SVector<f64, U>,
    ) -> Result<()> {
        self.filter.predict(motion, u)?;
        let belief = *self.filter.belief();
        let link = Link::Tangent { jacobian: *motion.transition(), noise: *motion.noise() };
        self.past.linked(link, &belief);
        Ok(())
    }

    /// See [`KalmanFilter::correct`].
    ///
    /// # Errors
    /// Those of the filter; nothing is then recorded.
    pub fn correct<const M: usize>(
        &mut self,
        sensor: &LinearMeasurement<N, M>,
        z: &SVector<f64, M>,
        gate: &Gate,
    ) -> Result<Innovation<M>> {
        let innovation = self.filter.correct(sensor, z, gate)?;
        self.past.corrected(self.filter.belief());
        Ok(innovation)
    }
}

impl<F: NonlinearFilter<N>, const N: usize> Recorded<F, N> {
    /// See [`NonlinearFilter::predict`].
    ///
    /// # Errors
    /// Those of the filter; nothing is then recorded.
    pub fn predict(&mut self, motion: &impl MotionModel<N>) -> Result<()> {
        self.predict_linked(motion).map(|_| ())
    }

    /// See [`NonlinearFilter::correct`].
    ///
    /// # Errors
    /// Those of the filter; nothing is then recorded.
    pub fn correct<const M: usize>(
        &mut self,
        sensor: &impl MeasurementModel<N, M>,
        z: &SVector<f64, M>,
        gate: &Gate,
    ) -> Result<Innovation<M>> {
        let innovation = self.filter.correct(sensor, z, gate)?;
        self.past.corrected(self.filter.belief());
        Ok(innovation)
    }
}

impl<F: Recordable<N>, const N: usize> Recordable<N> for Recorded<F, N> {
    fn belief(&self) -> &Gaussian<N> {
        self.filter.belief()
    }

    fn angles(&self) -> &'static [usize] {
        self.filter.angles()
    }
}

impl<F: NonlinearFilter<N>, const N: usize> NonlinearFilter<N> for Recorded<F, N> {
    const SECOND_ORDER: bool = F::SECOND_ORDER;

    fn start(belief: Gaussian<N>, angles: &'static [usize]) -> Result<Self> {
        Ok(Recorded::new(F::start(belief, angles)?))
    }

    fn predict_linked(&mut self, motion: &impl MotionModel<N>) -> Result<Link<N>> {
        let link = self.filter.predict_linked(motion)?;
        self.past.linked(link, self.filter.belief());
        Ok(link)
    }

    fn correct<const M: usize>(
        &mut self,
        sensor: &impl MeasurementModel<N, M>,
        z: &SVector<f64, M>,
        gate: &Gate,
    ) -> Result<Innovation<M>> {
        self.correct(sensor, z, gate)
    }

    fn mark(&mut self) {
        self.past.mark();
    }
}

/// A localizer that keeps its past, so that its estimates can be smoothed after the run.
pub trait Smoothable: Sequential {
    /// The smoothed estimate of each mark ([`Sequential::mark`]), in the order of the marks.
    ///
    /// # Errors
    /// Those of [`Smoother::smooth`].
    fn smoothed(&self) -> Result<Vec<Estimate>>;
}

/// The estimates at `stamps` \[s\], in order of time, of a localizer that has seen all events: those
/// before and those after.
///
/// The events are applied in order of their stamps, so that late ones are not late; an estimate is
/// taken after the inputs of its time.
///
/// # Errors
/// What the localizer refuses, and those of [`Smoother::smooth`].
pub fn smooth<L: Smoothable>(
    mut localizer: L,
    events: &[Event],
    stamps: &[f64],
) -> Result<Vec<Estimate>> {
    let mut inputs: Vec<(f64, u64, Option<Event>)> =
        Vec::with_capacity(events.len() + stamps.len());
    let mut odometry = OdometryVelocity::default();
    for event in events {
        let (from, stamp, payload) = match &event.payload {
            Payload::Control(Control::Odometry(pose)) if !L::USES_POSES => {
                let Some((from, twist)) = odometry.next(event.stamp, *pose) else { continue };
                (from, from, Payload::Control(Control::Velocity(twist)))
            }
            Payload::Measurement(measurement) if !localizer.uses(measurement) => continue,
            Payload::Measurement(measurement) => {
                let from = localizer.acts_from(event.stamp, measurement);
                (from, event.stamp, event.payload.clone())
            }
            Payload::Control(_) => (event.stamp, event.stamp, event.payload.clone()),
            Payload::Truth(_) => continue,
        };
        inputs.push((from, L::rank(&payload), Some(Event::now(stamp, payload))));
    }
    inputs.extend(stamps.iter().map(|&stamp| (stamp, u64::MAX, None)));
    // The sort is stable: inputs of one time and rank keep the order in which they came.
    inputs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    for (stamp, _, input) in &inputs {
        match input {
            Some(input) => drop(apply(&mut localizer, input)?),
            None => localizer.mark(*stamp)?,
        }
    }
    localizer.smoothed()
}
