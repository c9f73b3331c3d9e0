//! The simulated wheel odometry of a differential drive.

use super::WheelFaults;
use crate::Result;
use loc_core::Twist2;
use loc_core::kinematics::Differential;
use loc_core::motion::VelocityNoise;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

/// Simulates what the wheels report of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelOdometry {
    drive: Differential,
    noise: VelocityNoise,
    faults: WheelFaults,
}

impl WheelOdometry {
    /// Perfect odometry of a drive whose wheels are `track` \[m\] apart.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] unless the track is positive.
    pub fn new(track: f64) -> Result<Self> {
        let drive = Differential::new(track)?;
        Ok(WheelOdometry { drive, noise: VelocityNoise::NONE, faults: WheelFaults::NONE })
    }

    /// Adds random errors after the lectures' error model (E7).
    #[must_use]
    pub fn with_noise(mut self, noise: VelocityNoise) -> Self {
        self.noise = noise;
        self
    }

    /// Adds systematic errors.
    ///
    /// # Errors
    /// Those of [`WheelFaults::check`].
    pub fn with_faults(mut self, faults: WheelFaults) -> Result<Self> {
        faults.check()?;
        self.faults = faults;
        Ok(self)
    }

    /// The velocity that the wheels report of a step of `dt` \[s\] at the true velocity `twist`.
    ///
    /// Sideways motion turns no wheel and is not seen.
    pub fn measure<R: Rng + ?Sized>(&self, twist: Twist2, dt: f64, rng: &mut R) -> Twist2 {
        let seen = self.through_the_wheels(twist, dt, rng);
        let sigma = self.noise.variances(twist, dt).map(f64::sqrt);
        let mut draw = || -> f64 { StandardNormal.sample(rng) };
        Twist2::forward(seen.vx + sigma.x * draw(), seen.omega + sigma.z * draw())
    }

    /// True velocity -> true rims -> what each wheel turns -> the velocity the robot believes.
    fn through_the_wheels<R: Rng + ?Sized>(&self, twist: Twist2, dt: f64, rng: &mut R) -> Twist2 {
        let half_track = 0.5 * self.drive.track() * self.faults.track;
        let left = twist.vx - twist.omega * half_track;
        let right = twist.vx + twist.omega * half_track;
        let left = self.reported(left, self.faults.left_radius, dt, rng);
        let right = self.reported(right, self.faults.right_radius, dt, rng);
        self.drive.twist(left, right)
    }

    /// The rim speed that one wheel reports while its rim really moves at `rim` \[m/s\].
    ///
    /// Draws the same number of random values whatever the faults are.
    fn reported<R: Rng + ?Sized>(&self, rim: f64, radius: f64, dt: f64, rng: &mut R) -> f64 {
        let faults = &self.faults;
        let mut speed = rim / (radius * (1.0 - faults.sinkage));
        if rng.random::<f64>() < 1.0 - (-faults.slip_rate * dt).exp() {
            speed /= 1.0 - faults.slip;
        }
        if rng.random::<f64>() < 1.0 - (-faults.bumps_per_m * rim.abs() * dt).exp() {
            speed += rim.signum() * faults.bump / dt;
        }
        speed
    }
}
