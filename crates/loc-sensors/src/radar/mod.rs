//! A radar (B9): radio waves return from things with their distance, their direction, and by the
//! Doppler shift how fast they come or go.
//!
//! Of a velocity only the part along the ray is measured: something that crosses the view has none.
//! The robot's own motion is in it too, so that to a driving robot everything ahead approaches.
//! [`RadarReturn`] is one echo, [`RadarSpec`] the data sheet with its [`RadarNoise`], [`Radar`]
//! simulates it, with misses, false echoes, and walls that hide what is behind them.
//!
//! ```
//! use loc_core::{Pose2, Twist2, random::stream};
//! use loc_sensors::radar::{Radar, RadarNoise, RadarSpec};
//! use loc_sensors::world::{MovingObject, Room};
//! use nalgebra::{Point2, Vector2};
//! let spec = RadarSpec { noise: RadarNoise::NONE, ..RadarSpec::ars408_near() };
//! let radar = Radar::new(spec)?;
//! let room = Room::new([-50.0, -50.0], [50.0, 50.0])?;
//! let walker = MovingObject {
//!     position: Point2::new(10.0, 0.0),
//!     velocity: Vector2::new(-1.5, 0.5),
//!     radius: 0.0,
//! };
//! let (pose, twist) = (Pose2::IDENTITY, Twist2::forward(2.0, 0.0));
//! let echoes = radar.observe(&room, &[walker][..], pose, twist, &mut stream(1, "radar"));
//! assert!((echoes[0].radial_speed + 3.5).abs() < 1e-9, "they close in on each other");
//! # Ok::<(), loc_core::Error>(())
//! ```

mod echo;
mod noise;
mod simulated;
mod spec;

pub use echo::RadarReturn;
pub use noise::RadarNoise;
pub use simulated::Radar;
pub use spec::RadarSpec;
