//! Tests of `loc-core` through its public face, one module per module of the crate.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::float_cmp)]

mod finite_difference;
mod gaussian;
mod kinematics;
mod motion;
mod pose;
mod probability;
mod sampling;
mod settings;
mod stats;
mod table;
mod trajectory;
