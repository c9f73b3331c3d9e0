//! The common interface of nonlinear filters: the extended Kalman filter, the
//! unscented one, and either of them [recorded](crate::smoother::Recorded) for smoothing.
//!
//! A localizer that is written for any [`NonlinearFilter`] runs on all of them.
//!
//! ```
//! use loc_core::{Gaussian, Pose2, gaussian::pose_belief};
//! use loc_filters::{ExtendedKalmanFilter, NonlinearFilter, UnscentedKalmanFilter};
//!
//! fn heading<F: NonlinearFilter<3>>(start: Gaussian<3>) -> loc_filters::Result<f64> {
//!     Ok(F::start(start, &[2])?.belief().mean.z)
//! }
//! let start = pose_belief(Pose2::new(0.0, 0.0, 1.0), [0.1; 3]);
//! assert_eq!(
//!     heading::<ExtendedKalmanFilter<3>>(start)?,
//!     heading::<UnscentedKalmanFilter<3>>(start)?,
//! );
//! # Ok::<(), loc_filters::Error>(())
//! ```

use crate::extended::{ExtendedKalmanFilter, MeasurementModel, MotionModel};
use crate::smoother::{Link, Recordable};
use crate::unscented::UnscentedKalmanFilter;
use crate::{Gate, Innovation, Result};
use loc_core::Gaussian;
use nalgebra::SVector;

/// A nonlinear filter on the models of [`extended`](crate::extended).
pub trait NonlinearFilter<const N: usize>: Recordable<N> + Clone + std::fmt::Debug {
    /// Whether it sees how a model bends within its belief; else a model that bends strongly has to
    /// say so itself.
    const SECOND_ORDER: bool;
    /// A filter that starts from a belief whose states `angles` are angles.
    ///
    /// # Errors
    /// Those of [`Gaussian::new`].
    fn start(belief: Gaussian<N>, angles: &'static [usize]) -> Result<Self>;
    /// Prediction.
    ///
    /// # Errors
    /// Those of the filter; the belief is kept.
    fn predict(&mut self, motion: &impl MotionModel<N>) -> Result<()> {
        self.predict_linked(motion).map(|_| ())
    }
    /// Prediction that also returns how the states before and after are related.
    ///
    /// # Errors
    /// Those of the filter; the belief is kept.
    fn predict_linked(&mut self, motion: &impl MotionModel<N>) -> Result<Link<N>>;
    /// Correction with a measurement `z`, unless the gate rejects it.
    ///
    /// # Errors
    /// Those of the filter; the belief is kept.
    fn correct<const M: usize>(
        &mut self,
        sensor: &impl MeasurementModel<N, M>,
        z: &SVector<f64, M>,
        gate: &Gate,
    ) -> Result<Innovation<M>>;
    /// Marks the belief of this moment, of a filter that is recorded; other filters ignore it.
    fn mark(&mut self) {}
}

/// Both filters have the methods of the trait by the same names.
macro_rules! nonlinear_filter {
    ($filter:ident, bends: $bends:literal, |$self:ident, $motion:ident| $linked:expr) => {
        impl<const N: usize> Recordable<N> for $filter<N> {
            fn belief(&self) -> &Gaussian<N> {
                self.belief()
            }

            fn angles(&self) -> &'static [usize] {
                self.angles()
            }
        }

        impl<const N: usize> NonlinearFilter<N> for $filter<N> {
            const SECOND_ORDER: bool = $bends;

            fn start(belief: Gaussian<N>, angles: &'static [usize]) -> Result<Self> {
                Ok($filter::new(belief)?.with_angles(angles))
            }

            fn predict(&mut self, motion: &impl MotionModel<N>) -> Result<()> {
                self.predict(motion)
            }

            fn predict_linked(&mut $self, $motion: &impl MotionModel<N>) -> Result<Link<N>> {
                $linked
            }

            fn correct<const M: usize>(
                &mut self,
                sensor: &impl MeasurementModel<N, M>,
                z: &SVector<f64, M>,
                gate: &Gate,
            ) -> Result<Innovation<M>> {
                self.correct(sensor, z, gate)
            }
        }
    };
}

nonlinear_filter!(ExtendedKalmanFilter, bends: false, |self, motion| {
    let linear = motion.linearize(&self.belief().mean);
    self.predict_linearized(&linear)?;
    Ok(Link::Tangent { jacobian: linear.jacobian, noise: linear.noise })
});

nonlinear_filter!(UnscentedKalmanFilter, bends: true, |self, motion| {
    Ok(self.predict_points(motion)?.link())
});
