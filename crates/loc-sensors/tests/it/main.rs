//! Tests of `loc-sensors` through its public face, one module per topic.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::float_cmp)]

mod compass;
mod features;
mod gnss;
mod imu;
mod landmark_camera;
mod laser;
mod radar;
mod rgbd;
#[cfg(feature = "serde")]
mod settings;
mod sonar;
mod wheel;
mod world;
