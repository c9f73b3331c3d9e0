//! Tests of `loc-sim` through its public face, one module per module of the crate.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::float_cmp
)]

mod figures;
