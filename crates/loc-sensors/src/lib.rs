#![doc = include_str!("../README.md")]

mod check;
pub mod compass;
pub mod encoder;
pub mod event;
pub mod features;
pub mod gnss;
pub mod imu;
pub mod landmark_camera;
pub mod laser;
pub mod radar;
pub mod rgbd;
pub mod sonar;
pub mod wheel;
pub mod world;

/// The error type of this crate: the ground floor's, which says all that can go wrong here.
pub use loc_core::{Error, Result};
