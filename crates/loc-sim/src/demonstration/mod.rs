//! Demonstrations: what a method does inside, shown without a robot that drives through a world.
//!
//! The lectures explain the particle filter with pictures of its parts: five stages in a corridor
//! with doors ([`mcl_1d`], M2), and what resampling does to a robot that stands still
//! ([`diversity`], M11). The Bayes filter without particles is shown by a mailbox with a flag
//! ([`mailbox`], F5) and by another corridor with doors ([`door_corridor`], K1), and over the rooms of a building
//! ([`topological`], K1), lateration
//! in four rooms ([`lateration`], D1 to D4). Random numbers ([`sampling`], F2 to F4), maps ([`maps`],
//! C) and the perceptual model of a laser ([`perceptual_model`], K2) are shown by themselves. A
//! scenario asks for one of them by `[demonstration] kind = ".."`; the filters in them are those of
//! `loc-pf` and `loc-filters`, nothing is made up for the picture.
//!
//! ```
//! use loc_sim::scenario::Scenario;
//! let scenario = Scenario::named("mcl-1d", &["demonstration.particles=300".into()])?;
//! let illustration = scenario.illustrate(1)?.expect("it needs no method");
//! assert_eq!(illustration.figures[0].file, "stages.svg");
//! # Ok::<(), loc_sim::Error>(())
//! ```

pub mod diversity;
pub mod door_corridor;
pub mod lateration;
pub mod mailbox;
pub mod maps;
pub mod mcl_1d;
pub mod perceptual_model;
pub mod sampling;
pub mod topological;

pub use diversity::{Diversity, DiversityConfig};
pub use door_corridor::{DoorCorridor, DoorCorridorConfig};
pub use lateration::{Lateration, LaterationConfig};
pub use mailbox::{MailboxConfig, MailboxDiagnosis};
pub use maps::{Maps, MapsConfig};
pub use mcl_1d::{Mcl1d, Mcl1dConfig};
pub use perceptual_model::PerceptualModelConfig;
pub use sampling::{Sampling, SamplingConfig};
pub use topological::{TopologicalConfig, TopologicalTour};

use crate::Result;
use crate::output::Illustration;
use loc_plot::{Chart, Role};
use serde::Deserialize;

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
    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::Config`] and [`loc_core::Error::OutOfRange`] with the key.
    pub(crate) fn check(&self) -> Result<()> {
        match self {
            DemonstrationConfig::Mcl1d(config) => config.check(),
            DemonstrationConfig::Diversity(config) => config.check(),
            DemonstrationConfig::Lateration(config) => config.check(),
            DemonstrationConfig::Mailbox(config) => config.check(),
            DemonstrationConfig::DoorCorridor(config) => config.check(),
            DemonstrationConfig::Topological(config) => config.check(),
            DemonstrationConfig::Sampling(config) => config.check(),
            DemonstrationConfig::Maps(config) => config.check(),
            DemonstrationConfig::PerceptualModel(config) => config.check(),
        }
    }

    /// Runs it.
    ///
    /// # Errors
    /// Values out of range.
    pub(crate) fn illustrate(&self, title: &str, seed: u64) -> Result<Illustration> {
        Ok(match self {
            DemonstrationConfig::Mcl1d(config) => Mcl1d::new(config, seed)?.illustrate(title),
            DemonstrationConfig::Diversity(config) => {
                Diversity::new(config, seed)?.illustrate(title)
            }
            DemonstrationConfig::Lateration(config) => {
                Lateration::new(config, seed)?.illustrate(title)
            }
            DemonstrationConfig::Mailbox(config) => {
                MailboxDiagnosis::new(config)?.illustrate(title)
            }
            DemonstrationConfig::DoorCorridor(config) => {
                DoorCorridor::new(config, seed)?.illustrate(title)
            }
            DemonstrationConfig::Topological(config) => {
                TopologicalTour::new(config, seed)?.illustrate(title)
            }
            DemonstrationConfig::Sampling(config) => Sampling::new(config, seed)?.illustrate(title),
            DemonstrationConfig::Maps(config) => Maps::new(config)?.illustrate(),
            DemonstrationConfig::PerceptualModel(config) => {
                perceptual_model::illustrate(config, title, seed)?
            }
        })
    }
}

/// Checks a number of particles or steps.
///
/// # Errors
/// [`crate::Error::Config`] with the key.
fn count(key: &str, found: usize, most: usize) -> Result<()> {
    if (1..=most).contains(&found) {
        return Ok(());
    }
    Err(crate::config::field(key, &format!("1 to {most}"), &found.to_string()))
}

/// Adds bars to a chart, filled and with an edge, of pairs (middle, height).
fn bars(
    chart: Chart,
    role: Role,
    label: &str,
    width: f64,
    bars: impl Iterator<Item = (f64, f64)> + Clone,
) -> Chart {
    let sides = move |x: f64| [x - 0.5 * width, x + 0.5 * width];
    let gap = f64::NAN;
    let filled = bars.clone().flat_map(move |(x, height)| {
        let [left, right] = sides(x);
        [(left, 0.0, height), (right, 0.0, height), (gap, gap, gap)]
    });
    let edges = bars.flat_map(move |(x, height)| {
        let [left, right] = sides(x);
        [(left, 0.0), (left, height), (right, height), (right, 0.0), (gap, gap)]
    });
    chart.band(role, label, filled).line(role.width(0.8), "", edges)
}
