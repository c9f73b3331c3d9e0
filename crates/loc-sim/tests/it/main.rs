//! Tests of `loc-sim` through its public face, one module per topic.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::float_cmp)]

mod carmen;
#[cfg(feature = "cli")]
mod cli;
mod consistency;
#[cfg(feature = "cli")]
mod convergence;
mod convert;
mod demonstration;
mod drives;
#[cfg(feature = "cli")]
mod eval;
mod evo;
#[cfg(feature = "cli")]
mod fit_beam;
mod fusion;
mod guide;
mod histogram;
mod ids;
mod landmark_mcl;
mod layering;
mod line_matching;
#[cfg(feature = "cli")]
mod manners;
mod map;
mod mcl_accuracy;
mod metrics;
mod mrclam;
mod nav2;
mod particles;
mod ranging;
mod recordings;
#[cfg(feature = "cli")]
mod replay;
mod report;
mod ros;
mod scenarios;
mod seeds;
mod sense;
mod slam;
mod slam_recordings;
mod smoothing;
mod study;
mod switches;
mod tour;
mod ukf;
mod wean;
