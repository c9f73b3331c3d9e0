//! FastSLAM over stamped inputs, in order or late.

use super::{FastSlam, FastSlamSettings, finite_twist};
use crate::{Particles, Result};
use loc_core::motion::dead_reckon;
use loc_core::random::ChaCha8Rng;
use loc_core::{Gaussian, Twist2};
use loc_filters::delayed::{DelayedFilter, Step};
use loc_filters::slam::{MapLandmark, SlamOutcome};
use loc_sensors::landmark_camera::LandmarkObservation;

/// FastSLAM over stamped inputs, in order or late.
///
/// A velocity holds from its stamp until the next one. Observations may come between velocities,
/// several at one stamp, up to a horizon late, or not at all: the result is the same as if all had
/// come in order. For late ones the filter is kept as it was before every input within the horizon;
/// these copies share their maps.
#[derive(Debug, Clone)]
pub struct FastSlamLocalizer {
    filter: DelayedFilter<StampedSlam>,
}

/// The filter at the stamp of its last input, with the present velocity.
#[derive(Debug, Clone)]
struct StampedSlam {
    slam: FastSlam,
    stamp: f64,
    twist: Twist2,
}

/// An input.
#[derive(Debug, Clone)]
enum Input {
    Velocity(Twist2),
    Observations(Vec<LandmarkObservation>),
}

impl FastSlamLocalizer {
    /// A localizer that stands still at `stamp` \[s\] with a belief over (x, y, theta), and accepts
    /// inputs up to `horizon` \[s\] late.
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief, a stamp, a horizon or settings that are not valid.
    pub fn new(
        settings: FastSlamSettings,
        stamp: f64,
        start: Gaussian<3>,
        horizon: f64,
        rng: ChaCha8Rng,
    ) -> Result<Self> {
        let stamp = loc_core::error::finite("start time [s]", stamp)?;
        let slam = FastSlam::new(start, settings, rng)?;
        let stamped = StampedSlam { slam, stamp, twist: Twist2::ZERO };
        Ok(FastSlamLocalizer { filter: DelayedFilter::new(stamped, horizon)? })
    }

    /// The velocity from `stamp` \[s\] on.
    ///
    /// # Errors
    /// [`loc_filters::Error::TooLate`], and [`loc_filters::Error::NotFinite`] for the velocity.
    pub fn velocity(&mut self, stamp: f64, twist: Twist2) -> Result<()> {
        self.filter.input("velocity", stamp, Input::Velocity(twist))?;
        Ok(())
    }

    /// Any number of landmarks seen at `stamp` \[s\]; the result has one outcome for each.
    ///
    /// # Errors
    /// [`loc_filters::Error::TooLate`], and what [`FastSlam::correct`] refuses.
    pub fn observations(
        &mut self,
        stamp: f64,
        observations: &[LandmarkObservation],
    ) -> Result<Vec<SlamOutcome>> {
        Ok(self.filter.input("observations", stamp, Input::Observations(observations.to_vec()))?)
    }

    /// The belief about the robot at a time \[s\]: predicted from the last input before it.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a stamp that is not finite,
    /// [`loc_filters::Error::LostPositivity`].
    pub fn estimate(&self, stamp: f64) -> Result<Gaussian<3>> {
        loc_core::error::finite("stamp [s]", stamp)?;
        let stamped = self.filter.at(stamp);
        let pose = stamped.slam.pose()?;
        if stamp <= stamped.stamp {
            return Ok(pose);
        }
        let FastSlamSettings { integration, motion_noise, .. } = stamped.slam.settings();
        Ok(dead_reckon(&pose, stamped.twist, stamp - stamped.stamp, *integration, motion_noise))
    }

    /// The landmarks after the newest input; see [`FastSlam::landmarks`].
    ///
    /// # Errors
    /// [`loc_filters::Error::LostPositivity`].
    pub fn landmarks(&self) -> Result<Vec<MapLandmark>> {
        self.newest().landmarks()
    }

    /// The poses of the particles with their weights, after the newest input.
    pub fn particles(&self) -> Particles {
        self.newest().particles()
    }

    /// The filter after the newest input.
    pub fn newest(&self) -> &FastSlam {
        &self.filter.newest().slam
    }
}

impl Step for StampedSlam {
    type Input = Input;
    type Report = Vec<SlamOutcome>;

    fn step(&mut self, stamp: f64, input: &Input) -> loc_filters::Result<Vec<SlamOutcome>> {
        // Inputs from before the start belong to the start.
        let dt = (stamp - self.stamp).max(0.0);
        let before = self.clone();
        match self.take(dt, input) {
            Ok(outcomes) => Ok(outcomes),
            Err(error) => {
                *self = before;
                Err(error)
            }
        }
    }
}

impl StampedSlam {
    fn take(&mut self, dt: f64, input: &Input) -> loc_filters::Result<Vec<SlamOutcome>> {
        if dt > 0.0 {
            self.slam.drive(self.twist, dt)?;
        }
        self.stamp += dt;
        match input {
            Input::Velocity(twist) => {
                finite_twist(*twist)?;
                self.twist = *twist;
                Ok(Vec::new())
            }
            Input::Observations(observations) => self.slam.update(observations),
        }
    }
}
