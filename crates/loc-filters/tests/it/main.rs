//! Tests of `loc-filters` through its public face.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::float_cmp)]

mod association;
mod delayed;
mod extended;
mod fusion;
mod histogram;
mod innovation;
mod kalman;
mod landmark;
mod lateration;
mod line_matching;
mod slam;
mod smoother;
mod unscented;
