//! Rotary encoders (B1, B2): how far a shaft has turned, in counts.
//!
//! On a wheel the counts since last time give the way it rolled: [`WheelEncoder`] keeps the part of
//! a count that is not full yet, so that nothing is lost over time. On the steering of a car the
//! count is the steering angle: [`SteeringEncoder`] has play, a zero that is not quite zero, and
//! noise. Both round to whole counts, [`WheelTicks`] and [`SteeringCount`].
//!
//! ```
//! use loc_sensors::encoder::{WheelEncoder, WheelTicks};
//! let mut left = WheelEncoder::new(2048, 0.05)?;
//! let WheelTicks(ticks) = left.roll(1.0);
//! assert_eq!(ticks, 6518); // 1 m / (2 pi 0.05 m) turns
//! assert!((left.distance(WheelTicks(ticks)) - 1.0).abs() < 1e-3);
//! # Ok::<(), loc_core::Error>(())
//! ```

mod steering;
mod wheel;

pub use steering::{SteeringCount, SteeringEncoder, SteeringNoise};
pub use wheel::{WheelEncoder, WheelTicks};
