//! A car: driven behind, steered in front (E3), with an encoder on its steering (B2).

use super::disturbed;
use crate::Result;
use crate::source::OdometryNoiseConfig;
use loc_core::Twist2;
use loc_core::kinematics::Ackermann;
use loc_core::motion::VelocityNoise;
use loc_sensors::encoder::SteeringEncoder;
use rand::Rng;
use serde::Deserialize;

/// A car and what its odometry gets wrong.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AckermannConfig {
    /// From the rear axle, where its pose is, to the front axle.
    pub wheelbase_m: f64,
    /// Counts of the steering's encoder in a full turn of the wheels' angle.
    pub steering_counts: u32,
    /// Random errors of speed and turn rate.
    pub noise: Option<OdometryNoiseConfig>,
}

impl AckermannConfig {
    /// The library's form.
    pub(super) fn kinematics(&self) -> Result<Ackermann> {
        Ok(Ackermann::new(self.wheelbase_m)?)
    }

    pub(super) fn odometry(&self, noise: VelocityNoise) -> Result<AckermannOdometry> {
        let encoder = SteeringEncoder::new(self.steering_counts)?;
        Ok(AckermannOdometry { kinematics: self.kinematics()?, encoder, noise })
    }
}

/// The odometry of a car: its speed, and the angle that the encoder of the steering counts.
#[derive(Debug, Clone, Copy)]
pub(in crate::source::drive) struct AckermannOdometry {
    kinematics: Ackermann,
    encoder: SteeringEncoder,
    noise: VelocityNoise,
}

impl AckermannOdometry {
    pub(super) fn measure<R: Rng + ?Sized>(
        &mut self,
        twist: Twist2,
        dt: f64,
        rng: &mut R,
    ) -> Twist2 {
        let felt = Twist2 { vy: 0.0, ..disturbed(&self.noise, twist, dt, rng) };
        // A car that stands has no steering angle that its motion would tell.
        let Ok((speed, steering)) = self.kinematics.wheels(felt) else { return felt };
        let count = self.encoder.measure(steering, rng);
        self.kinematics.twist(speed, self.encoder.angle(count))
    }
}
