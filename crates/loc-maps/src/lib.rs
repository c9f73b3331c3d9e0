#![doc = include_str!("../README.md")]

pub mod distance;
mod error;
pub mod grid;
pub mod landmark;
pub mod likelihood_field;
pub mod raycast;

pub use distance::DistanceMap;
pub use error::{Error, Result};
pub use grid::OccupancyGrid;
pub use landmark::{Landmark, LandmarkMap};
pub use likelihood_field::LikelihoodField;
pub use raycast::RayCaster;
