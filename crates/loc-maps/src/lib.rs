#![doc = include_str!("../README.md")]

pub mod distance;
mod error;
pub mod grid;
pub mod landmark;

pub use distance::DistanceMap;
pub use error::{Error, Result};
pub use grid::OccupancyGrid;
pub use landmark::{Landmark, LandmarkMap};
