#![doc = include_str!("../README.md")]

pub mod adaptive;
mod elementary;
mod error;
pub mod estimate;
pub mod filter;
pub mod free_space;
pub mod global;
pub mod landmark_mcl;
mod log_weights;
pub mod mcl;
pub mod motion;
pub mod normals;
pub mod novelty;
pub mod particles;
pub mod policy;
pub mod recovery;
pub mod resample;
pub mod sensor;
pub mod tempering;
pub mod workers;

pub use adaptive::{Kld, KldSettings};
pub use error::{Error, Result};
pub use estimate::Estimate;
pub use filter::ParticleFilter;
pub use global::{GlobalSearch, SearchSettings};
pub use landmark_mcl::{LandmarkMcl, LandmarkMclSettings};
pub use mcl::{Mcl, MclSettings};
pub use motion::{Motion, Transport};
pub use particles::{Particles, Poses, PosesMut};
pub use policy::ResamplePolicy;
pub use resample::Resampling;
pub use sensor::Likelihood;
pub use tempering::Tempering;
pub use workers::Workers;
