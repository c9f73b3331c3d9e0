//! Sensor fusion: wheels, gyroscope, accelerometers, compass, satellites and landmarks in one
//! extended Kalman filter (H1).
//!
//! Each sensor knows something, none of them knows it all, and each may fall silent. The filter
//! believes twelve numbers: the pose, the speed and the turn rate, and how wrong the sensors are
//! that are wrong for longer: the biases of gyroscope and accelerometers, scale and offset of
//! ranges, the drift of the satellite receiver. Between measurements it predicts to the stamp of
//! the next one, whichever sensor it comes from; a measurement that fits too badly is turned away
//! by its gate. What no sensor tells becomes uncertain, at its own rate.
//!
//! Measurements may come late, up to the settings' horizon: the filter goes back, see
//! [`delayed`](crate::delayed). Of one stamp, the kinds have an order of their own, so that the
//! result does not depend on which came first.
//!
//! ```
//! use loc_core::{Gaussian, Pose2, Twist2, gaussian::pose_belief};
//! use loc_filters::fusion::{FusedLocalizer, FusionSettings};
//! use loc_maps::LandmarkMap;
//! use nalgebra::{Matrix2, Vector2};
//!
//! let start = pose_belief(Pose2::IDENTITY, [1.0, 1.0, 0.1]);
//! let mut robot =
//!     FusedLocalizer::new(LandmarkMap::default(), FusionSettings::default(), 0.0, start)?;
//! for k in 0..100 {
//!     robot.odometry(0.1 * f64::from(k), Twist2::forward(1.0, 0.0))?;
//! }
//! let satellites = Gaussian::new(Vector2::new(10.0, 0.5), Matrix2::identity() * 4.0)?;
//! robot.position(9.95, satellites)?;
//! let belief = robot.estimate(10.0)?;
//! assert!((belief.pose().x - 10.0).abs() < 0.1);
//! # Ok::<(), loc_filters::Error>(())
//! ```

mod held;
mod models;
mod motion;
mod outcome;
mod pulse;
mod settings;
mod start;
pub mod state;

pub use models::{
    CompassModel, DirectionModel, DistanceModel, InertialModel, ObservationModel, PositionModel,
    WheelModel,
};
pub use motion::FusedMotion;
pub use outcome::{FusionOutcome, FusionSensor};
pub use settings::FusionSettings;
pub use state::FusedBelief;

use crate::delayed::DelayedFilter;
use crate::smoother::Recorded;
use crate::{ExtendedKalmanFilter, NonlinearFilter, Result};
use held::{Held, Input};
use loc_core::{Gaussian, Twist2};
use loc_maps::LandmarkMap;
use loc_sensors::compass::CompassReading;
use loc_sensors::imu::ImuReading;
use loc_sensors::landmark_camera::LandmarkObservation;
use state::STATES;
use std::sync::Arc;

/// Localization with whatever sensors there are, on stamped inputs; with the extended Kalman filter,
/// unless another one is named.
#[derive(Debug, Clone)]
pub struct FusedLocalizer<F: NonlinearFilter<STATES> = ExtendedKalmanFilter<STATES>> {
    filter: DelayedFilter<Held<F>>,
    /// Between two samples of the inertial unit \[s\].
    period: f64,
}

impl FusedLocalizer {
    /// A robot with a belief over (x, y, theta) at `stamp` \[s\], and a map of landmarks, which may
    /// be empty.
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief, a stamp or settings that are not valid.
    pub fn new(
        map: impl Into<Arc<LandmarkMap>>,
        settings: FusionSettings,
        stamp: f64,
        start: Gaussian<3>,
    ) -> Result<Self> {
        FusedLocalizer::with_filter(map, settings, stamp, start)
    }
}

impl<F: NonlinearFilter<STATES>> FusedLocalizer<F> {
    /// A robot with any filter.
    ///
    /// # Errors
    /// As [`FusedLocalizer::new`].
    pub fn with_filter(
        map: impl Into<Arc<LandmarkMap>>,
        settings: FusionSettings,
        stamp: f64,
        start: Gaussian<3>,
    ) -> Result<Self> {
        let stamp = loc_core::error::finite("start time [s]", stamp)?;
        let held = Held::new(map.into(), settings, stamp, &start)?;
        let filter = DelayedFilter::new(held, settings.horizon)?;
        Ok(FusedLocalizer { filter, period: 1.0 / settings.imu.rate })
    }

    /// The velocity that the wheels measured, from `stamp` \[s\] on.
    ///
    /// # Errors
    /// [`crate::Error::TooLate`]; [`crate::Error::NotFinite`] for the velocity;
    /// [`crate::Error::LostPositivity`].
    pub fn odometry(&mut self, stamp: f64, twist: Twist2) -> Result<FusionOutcome> {
        crate::innovation::finite("velocity of the wheels", &twist.to_vector())?;
        self.one("odometry", stamp, Input::Odometry(twist), FusionSensor::Wheels)
    }

    /// A sample of the inertial unit: the mean over one period of the settings' rate up to
    /// `stamp` \[s\], as units average. It is put where the period begins, so that the horizon
    /// must not be shorter.
    ///
    /// # Errors
    /// As [`odometry`](FusedLocalizer::odometry), and [`loc_core::Error::OutOfRange`].
    pub fn inertial(&mut self, stamp: f64, reading: ImuReading) -> Result<FusionOutcome> {
        reading.check()?;
        let from = stamp - self.period;
        self.one("inertial sample", from, Input::Inertial(reading), FusionSensor::Inertial)
    }

    /// A heading of the compass.
    ///
    /// # Errors
    /// As [`odometry`](FusedLocalizer::odometry), and [`loc_core::Error::OutOfRange`].
    pub fn compass(&mut self, stamp: f64, reading: CompassReading) -> Result<FusionOutcome> {
        reading.check()?;
        self.one("heading", stamp, Input::Compass(reading), FusionSensor::Compass)
    }

    /// A position of the satellite receiver's antenna in the map \[m\], with the covariance that
    /// the receiver claims.
    ///
    /// # Errors
    /// As [`odometry`](FusedLocalizer::odometry), and [`loc_core::Error::NotACovariance`].
    pub fn position(&mut self, stamp: f64, fix: Gaussian<2>) -> Result<FusionOutcome> {
        let fix = Gaussian::new(fix.mean, fix.covariance)?;
        self.one("position", stamp, Input::Position(fix), FusionSensor::Position)
    }

    /// Any number of landmarks seen at `stamp` \[s\]; the answer has one outcome for each.
    ///
    /// # Errors
    /// As [`odometry`](FusedLocalizer::odometry), and [`loc_core::Error::OutOfRange`] for observations
    /// that are not valid, none of which is then used.
    pub fn observations(
        &mut self,
        stamp: f64,
        observations: &[LandmarkObservation],
    ) -> Result<Vec<FusionOutcome>> {
        for observation in observations {
            observation.sight.check()?;
        }
        self.filter.input("observations", stamp, Input::LandmarkObservations(observations.to_vec()))
    }

    /// The belief at a time \[s\]: predicted from the last input before it.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a stamp that is not finite,
    /// [`crate::Error::LostPositivity`].
    pub fn estimate(&self, stamp: f64) -> Result<FusedBelief> {
        loc_core::error::finite("stamp [s]", stamp)?;
        let mut held = self.filter.at(stamp).clone();
        held.drive_to(stamp)?;
        held.belief()
    }

    fn one(
        &mut self,
        what: &'static str,
        stamp: f64,
        input: Input,
        sensor: FusionSensor,
    ) -> Result<FusionOutcome> {
        let outcomes = self.filter.input(what, stamp, input)?;
        Ok(outcomes.first().copied().unwrap_or(FusionOutcome::refused(sensor)))
    }
}

impl<F: NonlinearFilter<STATES>> FusedLocalizer<Recorded<F, STATES>> {
    /// Asks for the belief at a time \[s\], to be smoothed later.
    ///
    /// # Errors
    /// As [`odometry`](FusedLocalizer::odometry).
    pub fn mark(&mut self, stamp: f64) -> Result<()> {
        self.filter.input("mark", stamp, Input::Mark).map(|_| ())
    }

    /// The smoothed belief at each mark, in the order of their times: what all that came before and
    /// after says, late inputs included.
    ///
    /// # Errors
    /// Those of [`Smoother::smooth`](crate::smoother::Smoother::smooth).
    pub fn smooth(&self) -> Result<Vec<FusedBelief>> {
        let marked = self.filter.newest().past().smooth_marked()?;
        Ok(marked.into_iter().map(FusedBelief).collect())
    }
}
