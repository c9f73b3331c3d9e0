//! An ultrasonic ranger (B11): a sound goes out in a cone, the time until an echo returns gives
//! one distance.
//!
//! Where in the cone the echo came from the sensor cannot tell. A wall that is met at a slant
//! throws the sound elsewhere and gives no echo at all; glass, which a laser looks through, gives
//! a good one. [`SonarRange`] is the measurement, [`SonarSpec`] the data sheet with its
//! [`SonarNoise`], [`Sonar`] simulates it.
//!
//! ```
//! use loc_core::{Pose2, random::stream};
//! use loc_sensors::sonar::{Sonar, SonarSpec};
//! use loc_sensors::world::Room;
//! let sonar = Sonar::new(SonarSpec::hc_sr04())?;
//! let room = Room::new([-1.0, -1.0], [2.0, 1.5])?;
//! let echo = sonar.measure(&room, Pose2::new(0.0, 0.0, 0.1), &mut stream(1, "sonar"));
//! assert!((echo.range - 2.0).abs() < 0.02, "a little to the side, the cone still holds the wall");
//! # Ok::<(), loc_core::Error>(())
//! ```

mod noise;
mod range;
mod simulated;
mod spec;

pub use noise::SonarNoise;
pub use range::SonarRange;
pub use simulated::Sonar;
pub use spec::SonarSpec;
