//! Tests of loc-pf, one module per topic.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::float_cmp)]

mod beam;
mod landmark;
mod landmark_mcl;
mod sensor_resetting;
