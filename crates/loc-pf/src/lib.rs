#![doc = include_str!("../README.md")]
//!
//! | Module | Contents |
//! |---|---|
//! | [`mcl`] | Monte Carlo localization with lasers: the whole filter |
//! | [`landmark_mcl`] | Monte Carlo localization with landmarks |
//! | [`fastslam`] | FastSLAM 2.0 |
//! | [`filter`], [`particles`], [`initial`] | the plain particle filter, its particles, initial particles |
//! | [`motion`] | motion models, which sample |
//! | [`sensor`] | likelihoods: beam model, likelihood field, landmarks, learned model |
//! | [`resample`], [`adaptive`] | resampling schemes, when to resample, how many particles (KLD) |
//! | [`tempering`] | updates in stages, for narrow likelihoods |
//! | [`estimate`] | mean, covariance and clusters |
//! | [`recovery`], [`confidence`] | when to search for the robot elsewhere, the probability of being lost |
//! | [`novelty`] | filters against people and new objects |
//! | [`delay`] | delay between odometry and scans |
//! | [`workers`], [`normals`] | threads, fast normal random numbers |
//!
//! The search of the whole map for a scan is [`loc_maps::search`].

pub mod adaptive;
pub mod confidence;
pub mod delay;
mod elementary;
mod error;
pub mod estimate;
pub mod fastslam;
pub mod filter;
pub mod initial;
pub mod landmark_mcl;
mod log_weights;
pub mod mcl;
pub mod motion;
pub mod normals;
pub mod novelty;
pub mod particles;
pub mod recovery;
pub mod resample;
pub mod sensor;
pub mod tempering;
pub mod workers;

pub use adaptive::{Kld, KldSettings};
pub use error::{Error, Result};
pub use estimate::Estimate;
pub use fastslam::{FastSlam, FastSlamLocalizer, FastSlamSettings};
pub use filter::ParticleFilter;
pub use landmark_mcl::{LandmarkMcl, LandmarkMclSettings};
pub use mcl::{Mcl, MclSettings};
pub use motion::{Motion, Transport};
pub use particles::{Particles, Poses, PosesMut};
pub use resample::{ResamplePolicy, Resampling};
pub use sensor::Likelihood;
pub use tempering::Tempering;
pub use workers::Workers;
