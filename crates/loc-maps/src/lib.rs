#![doc = include_str!("../README.md")]

mod error;
pub mod grid;
pub mod landmark;

pub use error::{Error, Result};
pub use grid::OccupancyGrid;
pub use landmark::{Landmark, LandmarkMap};
