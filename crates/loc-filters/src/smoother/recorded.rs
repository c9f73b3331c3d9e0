//! Filters that record their past for smoothing.

use super::{Link, Recordable, Smoother};
use crate::kalman::{LinearMeasurement, LinearMotion};
use crate::{
    Gate, Innovation, KalmanFilter, MeasurementModel, MotionModel, NonlinearFilter, Result,
};
use loc_core::Gaussian;
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
