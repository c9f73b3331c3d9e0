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
//! let see = |range| LandmarkObservation { landmark: 7, observed: Observed::RangeBearing { range, bearing: 0.0 } };
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

pub use ekf::{EkfSlam, Identities, Jacobians, MapLandmark, MapSettings, SlamSettings};
pub use linear::{LinearSlam, LinearSlamLocalizer, RelativeObservation};

use crate::Result;
use crate::delayed::{Clock, Sequential};
use crate::localizer::{Estimate, EstimatedMap, Localizer, Outcome, observed_position};
use loc_core::motion::dead_reckon;
use loc_core::{Gaussian, Twist2};
use loc_sensors::event::{Control, Measurement};

/// EKF-SLAM over time-stamped inputs in order; [`Delayed`](crate::delayed::Delayed) around it takes
/// late ones, at the cost of a copy of the covariance for every correction within its horizon.
///
/// A velocity holds from its stamp until the next one. Observations may come between velocities,
/// several at one stamp, or not at all.
#[derive(Debug, Clone)]
pub struct SlamLocalizer {
    slam: EkfSlam,
    clock: Clock,
    twist: Twist2,
}

impl SlamLocalizer {
    /// A localizer without a map that stands still at `stamp` \[s\] with a belief over (x, y, theta).
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief, a stamp or settings that are not valid.
    pub fn new(settings: SlamSettings, stamp: f64, start: Gaussian<3>) -> Result<Self> {
        let clock = Clock::starting_at(stamp)?;
        Ok(SlamLocalizer { slam: EkfSlam::new(start, settings)?, clock, twist: Twist2::ZERO })
    }

    /// The filter after the last input.
    pub fn slam(&self) -> &EkfSlam {
        &self.slam
    }
}

impl Localizer for SlamLocalizer {
    fn predict(&mut self, stamp: f64, control: &Control) -> Result<()> {
        let Control::Velocity(twist) = control else { return Ok(()) };
        crate::innovation::finite("velocity", &twist.to_vector())?;
        let dt = self.clock.advance("velocity", stamp)?;
        self.slam.predict(self.twist, dt)?;
        self.twist = *twist;
        Ok(())
    }

    fn correct(&mut self, stamp: f64, measurement: &Measurement) -> Result<Vec<Outcome>> {
        let Measurement::Landmarks(observations) = measurement else { return Ok(Vec::new()) };
        for observation in observations {
            observation.observed.check()?;
        }
        let dt = self.clock.advance("observations", stamp)?;
        self.slam.predict(self.twist, dt)?;
        let mut outcomes = self.slam.correct(observations)?;
        let camera = self.slam.pose()?.pose() * self.slam.settings().robot.mounting;
        for (outcome, observation) in outcomes.iter_mut().zip(observations) {
            outcome.observed_at = observed_position(camera, observation);
        }
        Ok(outcomes)
    }

    fn estimate(&self, stamp: f64) -> Result<Estimate> {
        let dt = self.clock.until(loc_core::error::finite("stamp [s]", stamp)?);
        let pose = self.slam.pose()?;
        if dt <= 0.0 {
            return Ok(pose.into());
        }
        let crate::RobotSettings { integration, odometry, .. } = self.slam.settings().robot;
        Ok(dead_reckon(&pose, self.twist, dt, integration, &odometry).into())
    }

    fn map(&self) -> Result<Option<EstimatedMap>> {
        let known_association = self.slam.settings().identities == Identities::Known;
        Ok(Some(EstimatedMap { known_association, landmarks: self.slam.landmarks()? }))
    }
}

impl Sequential for SlamLocalizer {
    fn uses(&self, measurement: &Measurement) -> bool {
        matches!(measurement, Measurement::Landmarks(_))
    }
}
