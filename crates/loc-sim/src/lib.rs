#![doc = include_str!("../README.md")]

#[cfg(feature = "cli")]
pub mod cli;
mod config;
pub mod convert;
pub mod demonstration;
pub mod error;
pub mod localizer;
pub mod metrics;
pub mod nav2;
pub mod output;
pub mod perceptual;
pub mod probability_map;
pub mod record;
pub mod runner;
pub mod scenario;
pub mod sense;
pub mod source;
pub mod study;

pub use error::{Error, Result};
