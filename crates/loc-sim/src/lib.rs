#![doc = include_str!("../README.md")]

#[cfg(feature = "cli")]
pub mod cli;
pub mod error;
pub mod metrics;

pub use error::{Error, Result};
