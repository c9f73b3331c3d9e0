//! Dead reckoning: odometry alone, with its growing covariance (E2, E6, E7).
//!
//! Velocities are integrated as the prediction of the landmark filter does; poses of an odometry
//! are appended to the start pose, with the noise of the path between them.
//!
//! ```
//! use loc_core::{Pose2, Twist2, gaussian::pose_belief};
//! use loc_filters::dead_reckoning::DeadReckoning;
//! use loc_filters::{Localizer, RobotSettings};
//! use loc_sensors::event::Control;
//!
//! let start = pose_belief(Pose2::IDENTITY, [0.1, 0.1, 0.05]);
//! let mut robot = DeadReckoning::new(RobotSettings::default(), 0.0, start)?;
//! robot.predict(0.0, &Control::Velocity(Twist2::forward(0.5, 0.0)))?;
//! let estimate = robot.estimate(4.0)?;
//! assert!((estimate.pose.x - 2.0).abs() < 1e-9);
//! assert!(estimate.covariance.unwrap()[(1, 1)] > 0.01);
//! # Ok::<(), loc_filters::Error>(())
//! ```

use crate::landmark::LandmarkLocalizer;
use crate::localizer::{Estimate, Localizer, Outcome};
use crate::{Result, RobotSettings};
use loc_core::motion::{DrivenPath, PathNoise};
use loc_core::{Gaussian, Pose2};
use loc_maps::LandmarkMap;
use loc_sensors::event::{Control, Measurement};

/// Odometry alone, from velocities or from poses.
#[derive(Debug, Clone)]
pub struct DeadReckoning {
    velocities: LandmarkLocalizer,
    path_noise: PathNoise,
    /// The belief at the last pose of the odometry.
    belief: Gaussian<3>,
    odometry: Option<Pose2>,
}

impl DeadReckoning {
    /// A robot that stands still at `stamp` \[s\] with a belief over (x, y, theta). Velocities have the
    /// integration rule and noise of the odometry, poses the noise of the path.
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief, a stamp or settings that are not valid.
    pub fn new(robot: RobotSettings, stamp: f64, start: Gaussian<3>) -> Result<Self> {
        let velocities = LandmarkLocalizer::new(LandmarkMap::default(), robot, stamp, start)?;
        Ok(DeadReckoning { velocities, path_noise: robot.path, belief: start, odometry: None })
    }
}

// ANCHOR: localizer
impl Localizer for DeadReckoning {
    fn predict(&mut self, stamp: f64, control: &Control) -> Result<()> {
        let Control::Odometry(pose) = control else {
            return self.velocities.predict(stamp, control);
        };
        // `map_from_odom` stays constant, while the covariance grows with distance and rotation.
        if let Some(before) = self.odometry.replace(*pose) {
            let mut path = DrivenPath::starting_at(before);
            path.extend(*pose);
            self.belief = self.path_noise.belief_after(&path, &self.belief);
        }
        Ok(())
    }

    fn correct(&mut self, _stamp: f64, _measurement: &Measurement) -> Result<Vec<Outcome>> {
        Ok(Vec::new())
    }

    fn estimate(&self, stamp: f64) -> Result<Estimate> {
        match self.odometry {
            Some(_) => Ok(self.belief.into()),
            None => self.velocities.estimate(stamp),
        }
    }
}
// ANCHOR_END: localizer
