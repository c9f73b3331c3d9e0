//! The landmark EKF on the stamps of real sensors.

use super::{LandmarkFilter, LandmarkSettings, Outcome};
use crate::delayed::{DelayedFilter, Step};
use crate::{ExtendedKalmanFilter, NonlinearFilter, Result};
use loc_core::{Gaussian, Twist2};
use loc_maps::LandmarkMap;
use loc_sensors::landmark_camera::LandmarkObservation;
use std::sync::Arc;

/// Landmark localization over stamped inputs, in order or late.
///
/// A velocity holds from its stamp until the next one. LandmarkObservations may come between velocities,
/// several at one stamp, up to the settings' `horizon` late, or not at all.
///
/// With the extended Kalman filter, unless another one is named.
#[derive(Debug, Clone)]
pub struct LandmarkLocalizer<F: NonlinearFilter<3> = ExtendedKalmanFilter<3>> {
    filter: DelayedFilter<Held<F>>,
}

/// The filter at the stamp of its last input, with the velocity that it drives on with.
#[derive(Debug, Clone)]
struct Held<F> {
    ekf: LandmarkFilter<F>,
    stamp: f64,
    twist: Twist2,
    map: Arc<LandmarkMap>,
}

/// What the localizer is given.
#[derive(Debug, Clone)]
enum Input {
    Velocity(Twist2),
    LandmarkObservations(Vec<LandmarkObservation>),
}

impl LandmarkLocalizer {
    /// A localizer with the extended Kalman filter that stands still at `stamp` \[s\] with a belief over (x, y, theta).
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief, a stamp or settings that are not valid.
    pub fn new(
        map: impl Into<Arc<LandmarkMap>>,
        settings: LandmarkSettings,
        stamp: f64,
        start: Gaussian<3>,
    ) -> Result<Self> {
        LandmarkLocalizer::with_filter(map, settings, stamp, start)
    }
}

impl<F: NonlinearFilter<3>> LandmarkLocalizer<F> {
    /// A localizer with any filter that stands still at `stamp` \[s\].
    ///
    /// # Errors
    /// As [`LandmarkLocalizer::new`].
    pub fn with_filter(
        map: impl Into<Arc<LandmarkMap>>,
        settings: LandmarkSettings,
        stamp: f64,
        start: Gaussian<3>,
    ) -> Result<Self> {
        let stamp = loc_core::error::finite("start time [s]", stamp)?;
        let ekf = LandmarkFilter::new(start, settings)?;
        let held = Held { ekf, stamp, twist: Twist2::ZERO, map: map.into() };
        Ok(LandmarkLocalizer { filter: DelayedFilter::new(held, settings.horizon)? })
    }

    /// The velocity from `stamp` \[s\] on.
    ///
    /// # Errors
    /// [`crate::Error::TooLate`], and [`crate::Error::NotFinite`] for the velocity.
    pub fn velocity(&mut self, stamp: f64, twist: Twist2) -> Result<()> {
        self.filter.input("velocity", stamp, Input::Velocity(twist)).map(|_| ())
    }

    /// Any number of landmarks seen at `stamp` \[s\]; the answer has one outcome for each.
    ///
    /// # Errors
    /// [`crate::Error::TooLate`], and [`loc_core::Error::OutOfRange`] for observations that are not
    /// valid, none of which is then used.
    pub fn observations(
        &mut self,
        stamp: f64,
        observations: &[LandmarkObservation],
    ) -> Result<Vec<Outcome>> {
        self.filter.input("observations", stamp, Input::LandmarkObservations(observations.to_vec()))
    }

    /// The belief at a time \[s\]: predicted from the last input before it.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a stamp that is not finite.
    pub fn estimate(&self, stamp: f64) -> Result<Gaussian<3>> {
        loc_core::error::finite("stamp [s]", stamp)?;
        let mut held = self.filter.at(stamp).clone();
        if stamp > held.stamp {
            held.ekf.predict(held.twist, stamp - held.stamp)?;
        }
        Ok(*held.ekf.belief())
    }
}

impl<F: NonlinearFilter<3>> Step for Held<F> {
    type Input = Input;
    type Report = Vec<Outcome>;

    fn step(&mut self, stamp: f64, input: &Input) -> Result<Vec<Outcome>> {
        let mut ekf = self.ekf.clone();
        // Inputs from before the start belong to the start.
        let dt = (stamp - self.stamp).max(0.0);
        ekf.predict(self.twist, dt)?;
        let mut outcomes = Vec::new();
        match input {
            Input::Velocity(twist) => {
                crate::innovation::finite("velocity", &twist.to_vector())?;
                self.twist = *twist;
            }
            Input::LandmarkObservations(observations) => {
                for observation in observations {
                    outcomes.push(ekf.correct(&self.map, observation)?);
                }
            }
        }
        self.ekf = ekf;
        self.stamp += dt;
        Ok(outcomes)
    }
}
