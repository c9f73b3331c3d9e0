#![doc = include_str!("../README.md")]

mod error;
pub mod landmark;

pub use error::{Error, Result};
pub use landmark::{Landmark, LandmarkMap};
