//! What sliding lateration can be told.

use crate::Result;
use crate::lateration::{BiasPrior, Loss};
use loc_core::error::{finite, in_range, non_negative, positive};
use loc_core::motion::{Integration, VelocityNoise};
use loc_sensors::landmark_camera::LandmarkNoise;
use nalgebra::Point2;

/// All that sliding lateration can be told.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct SlidingSettings {
    /// How many of the last distances count.
    pub window: usize,
    /// Whether odometry carries older distances to now. Without it the robot is taken to stay
    /// about where it is.
    pub odometry: bool,
    /// Rule that turns velocities into poses.
    pub integration: Integration,
    /// How far odometry may be off.
    pub motion_noise: VelocityNoise,
    /// Without odometry: how fast the robot may be \[m/s\].
    pub walk: f64,
    /// How far distances may be off; the bearing's part is not used.
    pub range_noise: LandmarkNoise,
    /// How much outliers cost.
    pub loss: Loss,
    /// What is known of the sensor's bias.
    pub bias: BiasPrior,
    /// Place of the antenna on the robot \[m\].
    pub antenna: Point2<f64>,
    /// How late a distance may come \[s\].
    pub horizon: f64,
}

impl SlidingSettings {
    /// Checks every value.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] with the name of the first that is not allowed.
    pub fn check(&self) -> Result<()> {
        let allowed = |count: f64| (1.0..=1e4).contains(&count);
        in_range("distances in the window", "1 to 10000", self.window as f64, allowed)?;
        self.motion_noise.check()?;
        positive("speed of a robot without odometry [m/s]", self.walk)?;
        self.range_noise.check()?;
        positive("sigma of the range [m]", self.range_noise.range_sigma)?;
        if let Loss::Huber(k) | Loss::Cauchy(k) = self.loss {
            positive("bend of the loss [standard deviations]", k)?;
        }
        self.bias.check()?;
        finite("place of the antenna [m]", self.antenna.x)?;
        finite("place of the antenna [m]", self.antenna.y)?;
        non_negative("horizon for late inputs [s]", self.horizon)?;
        Ok(())
    }
}

impl Default for SlidingSettings {
    /// 50 distances with odometry, a robust loss, and a sensor whose scale is known to 10 % and
    /// whose offset to 20 cm, as radio ranging is out of the box.
    fn default() -> Self {
        SlidingSettings {
            window: 50,
            odometry: true,
            integration: Integration::ExactArc,
            motion_noise: VelocityNoise::default(),
            walk: 0.5,
            range_noise: LandmarkNoise { range_sigma: 0.1, ..LandmarkNoise::default() },
            // A landmark taken for another one stays in the window for long; it must not pull at all.
            loss: Loss::CAUCHY,
            bias: BiasPrior { scale_sigma: 0.1, offset_sigma: 0.2 },
            antenna: Point2::origin(),
            horizon: 2.0,
        }
    }
}
