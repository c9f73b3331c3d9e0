#![doc = include_str!("../README.md")]

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
