//! Tests of `loc-maps` through its public face, one module per topic.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::float_cmp)]

mod grid;
mod landmark;
