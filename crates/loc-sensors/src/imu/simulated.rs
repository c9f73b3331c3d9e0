//! The simulated unit.

use super::{ImuReading, ImuSpec, InertialNoise, STANDARD_GRAVITY};
use crate::Result;
use crate::check::finite_pose;
use loc_core::{Pose2, Twist2};
use nalgebra::{Rotation2, Vector2, Vector3};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// An inertial measurement unit on a robot that drives on a level floor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Imu {
    spec: ImuSpec,
    mounting: Pose2,
    /// Biases of accelerometers and gyroscopes, unknown before the first sample.
    biases: Option<(Vector3<f64>, Vector3<f64>)>,
}

impl Imu {
    /// A unit in the middle of the robot.
    ///
    /// # Errors
    /// Those of [`ImuSpec::check`].
    pub fn new(spec: ImuSpec) -> Result<Self> {
        spec.check()?;
        Ok(Imu { spec, mounting: Pose2::IDENTITY, biases: None })
    }

    /// Sets the unit's place on the robot, `base_from_imu`. Away from the middle it feels the
    /// robot's turns.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a pose that is not finite.
    pub fn with_mounting(mut self, mounting: Pose2) -> Result<Self> {
        finite_pose("mounting of an IMU", mounting)?;
        self.mounting = mounting;
        Ok(self)
    }

    /// The data sheet.
    pub fn spec(&self) -> &ImuSpec {
        &self.spec
    }

    /// The true biases of accelerometers \[m/s^2\] and gyroscopes \[rad/s\]; `None` before the
    /// first sample.
    pub fn biases(&self) -> Option<(Vector3<f64>, Vector3<f64>)> {
        self.biases
    }

    /// The sample of a robot at the true velocity `twist`, which changes by `change` per second
    /// (its components' derivatives, in the robot's frame), `dt` \[s\] > 0 after the last one.
    pub fn measure<R: Rng + ?Sized>(
        &mut self,
        twist: Twist2,
        change: Twist2,
        dt: f64,
        rng: &mut R,
    ) -> ImuReading {
        let ImuSpec { accelerometer, gyroscope, .. } = self.spec;
        let (acceleration_bias, gyroscope_bias) = match self.biases {
            None => (normal3(rng) * accelerometer.start_bias, normal3(rng) * gyroscope.start_bias),
            Some((acceleration, turn)) => (
                acceleration + normal3(rng) * accelerometer.bias_step_sigma(dt),
                turn + normal3(rng) * gyroscope.bias_step_sigma(dt),
            ),
        };
        self.biases = Some((acceleration_bias, gyroscope_bias));
        let force = self.force(twist, change);
        let turn = Vector3::new(0.0, 0.0, twist.omega);
        ImuReading {
            acceleration: sample(&accelerometer, force + acceleration_bias, dt, rng),
            angular_velocity: sample(&gyroscope, turn + gyroscope_bias, dt, rng),
        }
    }

    /// The true specific force in the unit's frame \[m/s^2\].
    fn force(&self, twist: Twist2, change: Twist2) -> Vector3<f64> {
        let omega = twist.omega;
        let arm = Vector2::new(self.mounting.x, self.mounting.y);
        // In a frame that turns, the velocity's derivative is that of its components plus
        // omega x v; the arm adds the tangential and the centripetal acceleration.
        let middle = Vector2::new(change.vx - omega * twist.vy, change.vy + omega * twist.vx);
        let tangential = Vector2::new(-arm.y, arm.x) * change.omega;
        let planar = middle + tangential - arm * (omega * omega);
        let turned = Rotation2::new(-self.mounting.theta) * planar;
        Vector3::new(turned.x, turned.y, STANDARD_GRAVITY)
    }
}

fn sample<R: Rng + ?Sized>(
    noise: &InertialNoise,
    value: Vector3<f64>,
    dt: f64,
    rng: &mut R,
) -> Vector3<f64> {
    let noisy = value + normal3(rng) * noise.sample_sigma(dt);
    noisy.map(|value| value.clamp(-noise.limit, noise.limit))
}

fn normal3<R: Rng + ?Sized>(rng: &mut R) -> Vector3<f64> {
    Vector3::from_fn(|_, _| StandardNormal.sample(rng))
}
