//! Four wheels with rollers, which carry a robot in every direction (E4).

use crate::Result;
use crate::source::OdometryNoiseConfig;
use loc_core::Twist2;
use loc_core::kinematics::{Mecanum, MecanumWheels};
use serde::Deserialize;

/// A Mecanum drive and what its odometry gets wrong.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MecanumConfig {
    /// Between front and rear axle.
    pub wheelbase_m: f64,
    /// Between left and right wheels.
    pub track_m: f64,
    /// Random errors.
    pub noise: Option<OdometryNoiseConfig>,
}

impl MecanumConfig {
    /// The velocity at rim speeds of the wheels: front left and right, rear left and right \[m/s\].
    pub(super) fn twist(&self, speeds: [f64; 4]) -> Result<Twist2> {
        let [front_left, front_right, rear_left, rear_right] = speeds;
        let wheels = MecanumWheels { front_left, front_right, rear_left, rear_right };
        Ok(Mecanum::new(self.wheelbase_m, self.track_m)?.twist(wheels))
    }
}
