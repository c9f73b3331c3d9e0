//! An inertial measurement unit (B3, B4): accelerometers and gyroscopes.
//!
//! A gyroscope measures how fast the robot turns, an accelerometer the specific force: its
//! acceleration, in a curve the centripetal one too, and gravity upwards. Both have two errors:
//! white noise, independent in every sample, and a bias that follows a random walk.
//! [`InertialNoise`] gives both in the units of data sheets, per root of bandwidth; integrated over
//! time, the noise makes angle and speed random walks as well. [`ImuReading`] is one sample,
//! [`Imu`] simulates the device.
//!
//! ```
//! use loc_core::{Twist2, random::stream};
//! use loc_sensors::imu::{Imu, ImuSpec, STANDARD_GRAVITY};
//! let mut imu = Imu::new(ImuSpec::adis16448())?;
//! let curve = Twist2::forward(2.0, 0.5);
//! let reading = imu.measure(curve, Twist2::ZERO, 0.005, &mut stream(1, "imu"));
//! assert!((reading.angular_velocity.z - 0.5).abs() < 0.02);
//! assert!((reading.acceleration.y - 1.0).abs() < 0.2, "2 m/s times 0.5 rad/s to the left");
//! assert!((reading.acceleration.z - STANDARD_GRAVITY).abs() < 0.2);
//! # Ok::<(), loc_core::Error>(())
//! ```

use crate::Result;
use crate::check::finite_pose;
use loc_core::error::{finite, non_negative, positive};
use loc_core::{Pose2, Twist2};
use nalgebra::{Rotation2, Vector2, Vector3};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// Acceleration of gravity by convention \[m/s^2\].
pub const STANDARD_GRAVITY: f64 = 9.806_65;

/// One sample in the device's frame: x forward, y left, z up.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ImuReading {
    /// Specific force: acceleration less gravity, +g along z at rest \[m/s^2\].
    pub acceleration: Vector3<f64>,
    /// Turn rates about the axes \[rad/s\].
    pub angular_velocity: Vector3<f64>,
}

impl ImuReading {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for NaN and infinity.
    pub fn check(&self) -> Result<()> {
        for value in self.acceleration.iter() {
            finite("acceleration [m/s^2]", *value)?;
        }
        for value in self.angular_velocity.iter() {
            finite("turn rate [rad/s]", *value)?;
        }
        Ok(())
    }
}

/// Errors of one axis; the unit U is m/s^2 or rad/s.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct InertialNoise {
    /// Density of the white noise \[U/sqrt(Hz)\]; also known as velocity or angle random walk.
    pub density: f64,
    /// Density of the noise that the bias sums up \[U/s/sqrt(Hz)\]; also known as rate random walk.
    pub bias_walk: f64,
    /// Standard deviation of the bias when the device starts \[U\].
    pub start_bias: f64,
    /// Largest magnitude that the device measures \[U\].
    pub limit: f64,
}

impl InertialNoise {
    /// A perfect axis.
    pub const NONE: InertialNoise =
        InertialNoise { density: 0.0, bias_walk: 0.0, start_bias: 0.0, limit: f64::MAX };

    /// Standard deviation of the white noise of a sample that averages over `dt` \[s\].
    pub fn sample_sigma(&self, dt: f64) -> f64 {
        self.density / dt.sqrt()
    }

    /// Standard deviation of the change of the bias in `dt` \[s\].
    pub fn bias_step_sigma(&self, dt: f64) -> f64 {
        self.bias_walk * dt.sqrt()
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for negative values, NaN and infinity, and a limit that is not
    /// positive.
    pub fn check(&self) -> Result<()> {
        non_negative("noise density of an inertial sensor", self.density)?;
        non_negative("bias walk of an inertial sensor", self.bias_walk)?;
        non_negative("bias at start of an inertial sensor", self.start_bias)?;
        positive("limit of an inertial sensor", self.limit)?;
        Ok(())
    }
}

/// Rate and errors of an inertial measurement unit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct ImuSpec {
    /// Samples per second \[Hz\].
    pub rate: f64,
    /// Errors of each accelerometer \[m/s^2\].
    pub accelerometer: InertialNoise,
    /// Errors of each gyroscope \[rad/s\].
    pub gyroscope: InertialNoise,
}

impl ImuSpec {
    /// Analog Devices ADIS16448, a calibrated industrial unit, with the four densities that the
    /// EuRoC data sets (Burri et al. 2016) state for it; 18 g and 1000 deg/s.
    pub fn adis16448() -> Self {
        ImuSpec {
            rate: 200.0,
            accelerometer: InertialNoise {
                density: 2.0e-3,
                bias_walk: 3.0e-3,
                start_bias: 0.0,
                limit: 18.0 * STANDARD_GRAVITY,
            },
            gyroscope: InertialNoise {
                density: 1.6968e-4,
                bias_walk: 1.9393e-5,
                start_bias: 0.0,
                limit: 1000_f64.to_radians(),
            },
        }
    }

    /// InvenSense MPU-6050, the unit of hobby robots: 400 ug/sqrt(Hz), 0.005 deg/s/sqrt(Hz), in
    /// its ranges 2 g and 250 deg/s.
    ///
    /// The data sheet gives no bias walk, and offsets (50 mg, 20 deg/s) that any driver takes out
    /// while the robot stands: walk and what is left at start are assumptions of the usual size.
    pub fn mpu6050() -> Self {
        ImuSpec {
            rate: 100.0,
            accelerometer: InertialNoise {
                density: 400e-6 * STANDARD_GRAVITY,
                bias_walk: 5e-4,
                start_bias: 0.02,
                limit: 2.0 * STANDARD_GRAVITY,
            },
            gyroscope: InertialNoise {
                density: 0.005_f64.to_radians(),
                bias_walk: 2e-5,
                start_bias: 0.02_f64.to_radians(),
                limit: 250_f64.to_radians(),
            },
        }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a rate that is not positive, and those of
    /// [`InertialNoise::check`].
    pub fn check(&self) -> Result<()> {
        positive("samples per second of an IMU [Hz]", self.rate)?;
        self.accelerometer.check()?;
        self.gyroscope.check()
    }
}

impl Default for ImuSpec {
    /// The [`ImuSpec::mpu6050`].
    fn default() -> Self {
        ImuSpec::mpu6050()
    }
}

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

    /// Sets the unit's place on the robot, `base_from_imu`. Off the centre it also
    /// measures accelerations by the robot's turns.
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
