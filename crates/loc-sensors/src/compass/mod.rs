//! A compass (B5): a magnetometer that finds north.
//!
//! It measures the magnetic field in the plane and takes its direction for magnetic north. That is
//! not true north: the [`Compass`] knows the difference, the declination, for its place, or a wrong
//! one. Steel doors and motors bend the field about them ([`Disturbance`]), iron on the robot
//! turns with it ([`CompassNoise::hard_iron`]). [`CompassReading`] gives the heading and how strong
//! the field was, which tells a bent field from a clean one.
//!
//! ```
//! use loc_core::{Pose2, random::stream};
//! use loc_sensors::compass::Compass;
//! let compass = Compass::default(); // A map whose x axis points east.
//! let reading = compass.measure(Pose2::new(0.0, 0.0, 0.7), &mut stream(1, "compass"));
//! assert!((reading.heading - 0.7).abs() < 0.1);
//! ```

mod noise;
mod reading;
mod simulated;

pub use noise::{CompassNoise, Disturbance};
pub use reading::CompassReading;
pub use simulated::Compass;
