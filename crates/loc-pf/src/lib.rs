#![doc = include_str!("../README.md")]

mod error;
pub mod estimate;
pub mod filter;
pub mod free_space;
pub mod mcl;
pub mod motion;
pub mod novelty;
pub mod particles;
pub mod resample;
pub mod sensor;
pub mod settings;
pub mod workers;

pub use error::{Error, Result};
pub use estimate::Estimate;
pub use filter::ParticleFilter;
pub use mcl::Mcl;
pub use motion::Motion;
pub use particles::{Particles, Poses, PosesMut};
pub use resample::Resampling;
pub use sensor::Likelihood;
pub use settings::MclSettings;
pub use workers::Workers;
