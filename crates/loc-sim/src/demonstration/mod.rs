//! Demonstrations: what a method does inside, shown without a robot that drives through a world.
//!
//! | scenario | shows |
//! |---|---|
//! | `mcl-1d` ([`Mcl1dConfig`]) | the particle filter in five stages, in a corridor with doors (M2) |
//! | `door-corridor` ([`DoorCorridorConfig`]) | the Bayes filter as a histogram, in such a corridor (K1) |
//! | `diversity` ([`DiversityConfig`]) | what resampling does to a robot that stands still (M11) |
//! | `mailbox` ([`MailboxConfig`]) | the Bayes filter over two states (F5) |
//! | `topological-localization` ([`TopologicalConfig`]) | Markov localization over the rooms of a building (K1) |
//! | `lateration` ([`LaterationConfig`]) | lateration in four rooms (D1 to D4) |
//! | `sampling` ([`SamplingConfig`]) | random numbers (F2 to F4) |
//! | `maps` ([`MapsConfig`]) | one world as every kind of map (C) |
//! | `perceptual-model` ([`PerceptualModelConfig`]) | the perceptual model of a laser (K2) |
//!
//! A scenario selects one by `[demonstration] kind = ".."`. Each implements [`Demonstration`]. The
//! filters are those of `loc-pf` and `loc-filters`.
//!
//! ```
//! use loc_sim::scenario::Scenario;
//! let scenario = Scenario::named("mcl-1d", &["demonstration.particles=300".into()])?;
//! let illustration = scenario.illustrate(1)?.expect("it needs no method");
//! assert_eq!(illustration.figures[0].file, "stages.svg");
//! # Ok::<(), loc_sim::Error>(())
//! ```

mod corridor;
mod diversity;
mod lateration;
mod mailbox;
mod maps;
mod sampling;
mod topological;

pub use crate::perceptual::PerceptualModelConfig;
pub use corridor::{DoorCorridorConfig, Mcl1dConfig, Stage, Step};
pub use diversity::{Course, Diversity, DiversityConfig};
pub use lateration::{LaterationConfig, Room, RoomConfig};
pub use mailbox::{Day, Flag, MailboxConfig, MailboxDiagnosis};
pub use maps::{Maps, MapsConfig};
pub use sampling::{Drawn, Moments, Sampling, SamplingConfig};
pub use topological::{TopologicalConfig, TopologicalTour, TourStep};

use crate::Result;
use crate::output::Illustration;
use serde::Deserialize;

/// A small experiment of the lectures. The settings in a scenario's `[demonstration]` implement it.
pub trait Demonstration {
    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::Config`] and [`loc_core::Error::OutOfRange`] with the key.
    fn check(&self) -> Result<()>;

    /// Runs the experiment with a seed, and draws it.
    ///
    /// # Errors
    /// Values out of range.
    fn run(&self, title: &str, seed: u64) -> Result<Illustration>;
}

/// A demonstration and its numbers.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum DemonstrationConfig {
    /// The stages of the filter in one dimension (M2).
    #[serde(rename = "mcl-1d")]
    Mcl1d(Mcl1dConfig),
    /// How many ancestors survive resampling (M11).
    Diversity(DiversityConfig),
    /// Places at measured distances from landmarks (D).
    Lateration(LaterationConfig),
    /// A mailbox and its flag (F5).
    Mailbox(MailboxConfig),
    /// Markov localization in one dimension (K1).
    DoorCorridor(DoorCorridorConfig),
    /// Markov localization over the places of a topological map (K1, C4).
    Topological(Box<TopologicalConfig>),
    /// Random numbers (F2 to F4).
    Sampling(SamplingConfig),
    /// One world as every kind of map (C).
    Maps(MapsConfig),
    /// What a laser measures where a map lets expect something (K2).
    PerceptualModel(PerceptualModelConfig),
}

impl DemonstrationConfig {
    fn demonstration(&self) -> &dyn Demonstration {
        match self {
            DemonstrationConfig::Mcl1d(config) => config,
            DemonstrationConfig::Diversity(config) => config,
            DemonstrationConfig::Lateration(config) => config,
            DemonstrationConfig::Mailbox(config) => config,
            DemonstrationConfig::DoorCorridor(config) => config,
            DemonstrationConfig::Topological(config) => &**config,
            DemonstrationConfig::Sampling(config) => config,
            DemonstrationConfig::Maps(config) => config,
            DemonstrationConfig::PerceptualModel(config) => config,
        }
    }
}

impl Demonstration for DemonstrationConfig {
    fn check(&self) -> Result<()> {
        self.demonstration().check()
    }

    fn run(&self, title: &str, seed: u64) -> Result<Illustration> {
        self.demonstration().run(title, seed)
    }
}

/// Checks a number of particles or steps: 1 to `max`.
///
/// # Errors
/// [`crate::Error::Config`] with the key.
pub(crate) fn check_count(key: &str, found: usize, max: usize) -> Result<()> {
    if (1..=max).contains(&found) {
        return Ok(());
    }
    Err(crate::config::field(key, &format!("1 to {max}"), &found.to_string()))
}
