//! Parameter files of nav2_amcl (`amcl.yaml`), read for this project's particle filter.
//!
//! A robot that runs ROS's AMCL has its settings in a YAML file: `amcl:`, below it
//! `ros__parameters:`, below it one key a line. Most of them have a counterpart here. What has none
//! is named in [`AmclParameters::warnings`], with the reason, so that nothing is dropped in
//! silence. What the file leaves out has this project's defaults, not those of nav2.
//!
//! ```
//! use loc_sim::nav2::AmclParameters;
//! let text = "amcl:\n  ros__parameters:\n    max_particles: 800\n    scan_topic: front/scan\n    map_topic: map\n";
//! let parameters = AmclParameters::parse("amcl.yaml", text)?;
//! assert_eq!(parameters.mcl.particles.max_particles, 800);
//! assert_eq!(parameters.names.scan_topic.as_deref(), Some("front/scan"));
//! assert_eq!(parameters.warnings, ["amcl.yaml:5: map_topic: the map comes from --map"]);
//! # Ok::<(), loc_sim::Error>(())
//! ```

mod given;
mod mapping;
mod nodes;
mod value;

use crate::Result;
use crate::source::ros::RosNames;
use loc_core::Pose2;
use loc_pf::MclSettings;
use std::path::Path;

/// What a parameter file asks for.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AmclParameters {
    /// Settings of the filter.
    pub mcl: MclSettings,
    /// Seed, where one is fixed.
    pub seed: Option<u64>,
    /// Start pose in the map, where one is set.
    pub start: Option<Pose2>,
    /// Standard deviations of the start pose over (x, y, theta) \[m, m, rad\], where given.
    pub start_sigmas: [Option<f64>; 3],
    /// Names of topics and frames, for bags.
    pub names: RosNames,
    /// The names as warnings, for recordings that are no bags.
    pub without_bag: Vec<String>,
    /// The keys that change nothing, a line each, with the reason.
    pub warnings: Vec<String>,
}

impl AmclParameters {
    /// Reads a parameter file.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`], else as [`AmclParameters::parse`].
    pub fn read(file: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(file).map_err(loc_core::Error::io(file))?;
        AmclParameters::parse(&file.display().to_string(), &text)
    }

    /// The same from a text; `file` is only named in errors and warnings.
    ///
    /// # Errors
    /// [`crate::Error::Config`] with the line for what is no YAML, has no parameters of amcl, or a
    /// value of the wrong type or out of range.
    pub fn parse(file: &str, text: &str) -> Result<Self> {
        mapping::map(nodes::parameters(file, text)?)
    }
}
