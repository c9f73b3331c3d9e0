//! Tests of loc-pf, one module per topic.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::float_cmp)]

mod beam;
mod clusters;
mod landmark;
mod landmark_mcl;
mod lost;
mod moments;
mod robot;
mod sensor_resetting;
