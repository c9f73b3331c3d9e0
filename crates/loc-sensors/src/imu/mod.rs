//! An inertial measurement unit (B3, B4): accelerometers and gyroscopes.
//!
//! A gyroscope measures how fast the robot turns, an accelerometer what force it feels: its
//! acceleration, in a curve the centripetal one too, and gravity upwards. Both err in two ways: by
//! noise that is new with every sample, and by a bias that wanders. [`InertialNoise`] gives both in
//! the units of data sheets, per root of bandwidth; summed over time the noise makes angle and
//! speed walk away as well. [`ImuReading`] is one sample, [`Imu`] simulates the device.
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

mod noise;
mod reading;
mod simulated;
mod spec;

pub use noise::InertialNoise;
pub use reading::ImuReading;
pub use simulated::Imu;
pub use spec::ImuSpec;

/// Acceleration of gravity by convention \[m/s^2\].
pub const STANDARD_GRAVITY: f64 = 9.806_65;
