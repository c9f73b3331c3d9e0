//! The landmark filter on stamped inputs, in order or late, and its smoother.

use super::{LandmarkFilter, LandmarkSettings, Outcome};
use crate::delayed::{DelayedFilter, Step};
use crate::smoother::{Recorded, Smoother};
use crate::{Error, ExtendedKalmanFilter, NonlinearFilter, Result};
use loc_core::{Gaussian, Twist2};
use loc_maps::LandmarkMap;
use loc_sensors::landmark_camera::LandmarkObservation;
use std::sync::Arc;

/// Landmark localization over stamped inputs, in order or late.
///
/// A velocity holds from its stamp until the next one. Observations may arrive between velocities,
/// several at one stamp, up to the settings' `horizon` late, or not at all.
///
/// With the extended Kalman filter, unless another one is named.
#[derive(Debug, Clone)]
pub struct LandmarkLocalizer<F: NonlinearFilter<3> = ExtendedKalmanFilter<3>> {
    filter: DelayedFilter<LocalizerState<F>>,
}

/// The filter at the stamp of its last input, and the velocity that holds since then.
#[derive(Debug, Clone)]
struct LocalizerState<F> {
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
        let state = LocalizerState { ekf, stamp, twist: Twist2::ZERO, map: map.into() };
        Ok(LandmarkLocalizer { filter: DelayedFilter::new(state, settings.horizon)? })
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
        let mut state = self.filter.at(stamp).clone();
        if stamp > state.stamp {
            state.ekf.predict(state.twist, stamp - state.stamp)?;
        }
        Ok(*state.ekf.belief())
    }
}

impl<F: NonlinearFilter<3>> Step for LocalizerState<F> {
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

/// Landmark localization after the drive: the inputs of
/// [`LandmarkLocalizer`](super::LandmarkLocalizer), in the order of their stamps, and marks at the
/// times whose smoothed beliefs are wanted. With the extended Kalman filter, unless another one is
/// named.
///
/// ```
/// use loc_core::{Pose2, Twist2, gaussian::pose_belief};
/// use loc_filters::landmark::{LandmarkSettings, LandmarkSmoother};
/// use loc_maps::{Landmark, LandmarkMap};
/// use loc_sensors::landmark_camera::{Observed, LandmarkObservation};
///
/// let map = LandmarkMap::new([Landmark::planar(1, 4.0, 0.0)])?;
/// let start = pose_belief(Pose2::IDENTITY, [0.5, 0.5, 0.1]);
/// let mut drive = LandmarkSmoother::new(map, LandmarkSettings::default(), 0.0, start)?;
/// drive.velocity(0.0, Twist2::forward(1.0, 0.0))?;
/// drive.mark(0.0)?;
/// let sight = Observed::RangeBearing { range: 2.5, bearing: 0.0 };
/// drive.observations(1.0, &[LandmarkObservation { landmark: 1, sight }])?;
/// let smoothed = drive.smooth()?;
/// assert!(smoothed[0].mean.x > 0.4, "what is seen at 1 s says where the robot was at 0 s");
/// # Ok::<(), loc_filters::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct LandmarkSmoother<F: NonlinearFilter<3> = ExtendedKalmanFilter<3>> {
    filter: LandmarkFilter<Recorded<F, 3>>,
    stamp: f64,
    twist: Twist2,
    map: Arc<LandmarkMap>,
}

impl LandmarkSmoother {
    /// A drive that stands still at `stamp` \[s\] with a belief over (x, y, theta). The horizon of
    /// the settings has no meaning here.
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief, a stamp or settings that are not valid.
    pub fn new(
        map: impl Into<Arc<LandmarkMap>>,
        settings: LandmarkSettings,
        stamp: f64,
        start: Gaussian<3>,
    ) -> Result<Self> {
        LandmarkSmoother::with_filter(map, settings, stamp, start)
    }
}

impl<F: NonlinearFilter<3>> LandmarkSmoother<F> {
    /// A drive with any filter that stands still at `stamp` \[s\].
    ///
    /// # Errors
    /// As [`LandmarkSmoother::new`].
    pub fn with_filter(
        map: impl Into<Arc<LandmarkMap>>,
        settings: LandmarkSettings,
        stamp: f64,
        start: Gaussian<3>,
    ) -> Result<Self> {
        let stamp = loc_core::error::finite("start time [s]", stamp)?;
        let filter = LandmarkFilter::new(start, settings)?;
        Ok(LandmarkSmoother { filter, stamp, twist: Twist2::ZERO, map: map.into() })
    }

    /// The velocity from `stamp` \[s\] on.
    ///
    /// # Errors
    /// [`Error::TooLate`] for a stamp before the last one, and [`Error::NotFinite`] for the
    /// velocity.
    pub fn velocity(&mut self, stamp: f64, twist: Twist2) -> Result<()> {
        crate::innovation::finite("velocity", &twist.to_vector())?;
        self.drive_to("velocity", stamp)?;
        self.twist = twist;
        Ok(())
    }

    /// Any number of landmarks seen at `stamp` \[s\]; the answer has one outcome for each.
    ///
    /// # Errors
    /// [`Error::TooLate`] for a stamp before the last one, and [`loc_core::Error::OutOfRange`] for
    /// observations that are not valid, none of which is then used.
    pub fn observations(
        &mut self,
        stamp: f64,
        observations: &[LandmarkObservation],
    ) -> Result<Vec<Outcome>> {
        for observation in observations {
            observation.sight.check()?;
        }
        self.drive_to("observations", stamp)?;
        let mut filter = self.filter.clone();
        let outcomes =
            observations.iter().map(|observation| filter.correct(&self.map, observation));
        let outcomes = outcomes.collect::<Result<Vec<_>>>()?;
        self.filter = filter;
        Ok(outcomes)
    }

    /// Marks the belief at a time \[s\].
    ///
    /// # Errors
    /// [`Error::TooLate`] for a time before the last stamp.
    pub fn mark(&mut self, stamp: f64) -> Result<()> {
        self.drive_to("mark", stamp)?;
        self.filter.mark();
        Ok(())
    }

    /// The smoothed belief at each mark, in the order of the marks.
    ///
    /// # Errors
    /// Those of [`Smoother::smooth`].
    pub fn smooth(&self) -> Result<Vec<Gaussian<3>>> {
        self.past().smooth_marked()
    }

    /// The filtered belief at each mark.
    pub fn filtered(&self) -> Vec<Gaussian<3>> {
        self.past().filtered_marked()
    }

    fn past(&self) -> &Smoother<3> {
        self.filter.filter().past()
    }

    fn drive_to(&mut self, what: &'static str, stamp: f64) -> Result<()> {
        let dt = loc_core::error::finite("stamp [s]", stamp)? - self.stamp;
        // Inputs from before the start belong to the start.
        if dt < 0.0 && !self.past().is_empty() {
            return Err(Error::TooLate { what, stamp, newest: self.stamp, horizon: 0.0 });
        }
        if dt > 0.0 {
            self.filter.predict(self.twist, dt)?;
            self.stamp = stamp;
        }
        Ok(())
    }
}
