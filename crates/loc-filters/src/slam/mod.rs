//! Simultaneous localization and mapping: a robot without a map of the place (I1 to I4).
//!
//! The robot builds the map while it moves, and localizes in it at the same time. An error of its pose
//! is shared by all landmarks observed from there; the covariance between them records that. When the
//! robot observes an early landmark again, the correction changes the whole map. The filters here
//! therefore keep the full covariance, each element once, and their cost grows with its size.
//!
//! * [`LinearSlam`] is the simplest case, a robot that moves without turning (I1);
//! * [`EkfSlam`] has a heading, sees distance and direction, and can do without numbers on the
//!   landmarks (I2 to I4). [`SlamLocalizer`] around it takes stamped inputs, in order or late.
//!
//! ```
//! use loc_core::{Gaussian, Pose2, Twist2};
//! use loc_filters::slam::{EkfSlam, SlamSettings};
//! use loc_sensors::landmark_camera::{Observed, LandmarkObservation};
//!
//! let start = Gaussian::certain(Pose2::IDENTITY.to_vector());
//! let mut slam = EkfSlam::new(start, SlamSettings::default())?;
//! let see = |range| LandmarkObservation { landmark: 7, sight: Observed::RangeBearing { range, bearing: 0.0 } };
//! slam.correct(&[see(4.0)])?;
//! slam.predict(Twist2::forward(1.0, 0.0), 1.0)?;
//! slam.correct(&[see(2.9)])?;
//! let (robot, landmark) = (slam.pose()?, slam.landmark(7)?.unwrap());
//! assert!(robot.mean.x > 1.0 && (landmark.position.mean.x - 3.95).abs() < 0.05);
//! # Ok::<(), loc_filters::Error>(())
//! ```

mod ekf;
mod linear;
mod state;

pub use ekf::{
    EkfSlam, Identities, Jacobians, MapLandmark, MapSettings, SlamOutcome, SlamSettings,
    SlamVerdict,
};
pub use linear::{LinearSlam, LinearSlamSettings, RelativeObservation};

use crate::Result;
use crate::delayed::{DelayedFilter, Step};
use loc_core::{Gaussian, Twist2};
use loc_sensors::landmark_camera::LandmarkObservation;

/// SLAM over stamped inputs, in order or late.
///
/// A velocity holds from its stamp until the next one. Observations may arrive between velocities,
/// several at one stamp, up to a horizon late, or not at all. For late ones the filter is kept as
/// it was before every input within the horizon; each that was corrected since has a covariance of
/// its own, so that a map of thousands of landmarks goes with a horizon of 0.
#[derive(Debug, Clone)]
pub struct SlamLocalizer {
    filter: DelayedFilter<LocalizerState>,
}

/// The filter at the stamp of its last input, and the velocity that holds since then.
#[derive(Debug, Clone)]
struct LocalizerState {
    slam: EkfSlam,
    stamp: f64,
    twist: Twist2,
}

/// What the localizer is given.
#[derive(Debug, Clone)]
enum Input {
    Velocity(Twist2),
    LandmarkObservations(Vec<LandmarkObservation>),
}

impl SlamLocalizer {
    /// A localizer that stands still at `stamp` \[s\] with a belief over (x, y, theta), and takes
    /// inputs up to `horizon` \[s\] late.
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief, a stamp, a horizon or settings that are not valid.
    pub fn new(
        settings: SlamSettings,
        stamp: f64,
        start: Gaussian<3>,
        horizon: f64,
    ) -> Result<Self> {
        let stamp = loc_core::error::finite("start time [s]", stamp)?;
        let state =
            LocalizerState { slam: EkfSlam::new(start, settings)?, stamp, twist: Twist2::ZERO };
        Ok(SlamLocalizer { filter: DelayedFilter::new(state, horizon)? })
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
    /// [`crate::Error::TooLate`], and what [`EkfSlam::correct`] refuses.
    pub fn observations(
        &mut self,
        stamp: f64,
        observations: &[LandmarkObservation],
    ) -> Result<Vec<SlamOutcome>> {
        self.filter.input("observations", stamp, Input::LandmarkObservations(observations.to_vec()))
    }

    /// The belief about the robot at a time \[s\]: predicted from the last input before it.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a stamp that is not finite,
    /// [`crate::Error::LostPositivity`].
    pub fn estimate(&self, stamp: f64) -> Result<Gaussian<3>> {
        loc_core::error::finite("stamp [s]", stamp)?;
        let state = self.filter.at(stamp);
        let pose = state.slam.pose()?;
        if stamp <= state.stamp {
            return Ok(pose);
        }
        let SlamSettings { integration, motion_noise, .. } = state.slam.settings();
        let dt = stamp - state.stamp;
        Ok(loc_core::motion::dead_reckon(&pose, state.twist, dt, *integration, motion_noise))
    }

    /// The landmarks after the newest input.
    ///
    /// # Errors
    /// [`crate::Error::LostPositivity`].
    pub fn landmarks(&self) -> Result<Vec<MapLandmark>> {
        self.filter.newest().slam.landmarks()
    }

    /// The filter after the newest input.
    pub fn newest(&self) -> &EkfSlam {
        &self.filter.newest().slam
    }
}

impl Step for LocalizerState {
    type Input = Input;
    type Report = Vec<SlamOutcome>;

    fn step(&mut self, stamp: f64, input: &Input) -> Result<Vec<SlamOutcome>> {
        // Inputs from before the start belong to the start.
        let dt = (stamp - self.stamp).max(0.0);
        let before = self.clone();
        match self.apply(dt, input) {
            Ok(outcomes) => Ok(outcomes),
            Err(error) => {
                *self = before;
                Err(error)
            }
        }
    }
}

impl LocalizerState {
    fn apply(&mut self, dt: f64, input: &Input) -> Result<Vec<SlamOutcome>> {
        self.slam.predict(self.twist, dt)?;
        self.stamp += dt;
        match input {
            Input::Velocity(twist) => {
                crate::innovation::finite("velocity", &twist.to_vector())?;
                self.twist = *twist;
                Ok(Vec::new())
            }
            Input::LandmarkObservations(observations) => self.slam.correct(observations),
        }
    }
}
