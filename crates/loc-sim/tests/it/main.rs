//! Tests of `loc-sim` through its public face, one module per topic.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::float_cmp)]

mod claims;
#[cfg(feature = "cli")]
mod cli;
#[cfg(feature = "cli")]
mod convergence;
mod convert;
mod demonstration;
#[cfg(feature = "cli")]
mod eval;
mod evo;
#[cfg(feature = "cli")]
mod fit_beam;
mod guide;
mod histogram;
mod kalman;
mod landmark_mcl;
mod laser_logs;
mod layering;
mod line_matching;
#[cfg(feature = "cli")]
mod manners;
mod map;
mod mcl;
mod metrics;
mod mrclam;
mod nav2;
mod ranging;
#[cfg(feature = "cli")]
mod replay;
mod report;
mod ros;
mod scenarios;
mod seeds;
mod sense;
mod settings;
mod simulation;
mod slam;
mod smoothing;
mod study;
