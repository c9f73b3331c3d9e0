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

mod mapping;

use crate::Result;
use loc_core::Pose2;
use loc_pf::MclSettings;
use loc_ros::{Found, NodeParameters, RosNames};
use std::path::Path;

/// The node whose parameters are read.
const NODE: &str = "amcl";

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
        AmclParameters::of(NodeParameters::read(file, NODE)?)
    }

    /// The same from a text; `file` is only named in errors and warnings.
    ///
    /// # Errors
    /// [`loc_ros::Error::Parameters`] with the line for what is no YAML, has no parameters of amcl, or a
    /// value of the wrong type or out of range.
    pub fn parse(file: &str, text: &str) -> Result<Self> {
        AmclParameters::of(NodeParameters::parse(file, text, NODE)?)
    }

    fn of(mut given: NodeParameters) -> Result<Self> {
        let mut parameters = AmclParameters::default();
        mapping::motion(&mut given, &mut parameters.mcl)?;
        mapping::particles(&mut given, &mut parameters)?;
        mapping::recovery(&mut given, &mut parameters.mcl)?;
        mapping::laser(&mut given, &mut parameters.mcl)?;
        start(&mut given, &mut parameters)?;
        names(&mut given, &mut parameters)?;
        parameters.mcl.check().map_err(|error| given.error(&error))?;
        parameters.warnings = given.into_warnings();
        Ok(parameters)
    }
}

/// The start pose, and how well it is known.
fn start(given: &mut NodeParameters, parameters: &mut AmclParameters) -> Result<()> {
    let mut covariance = |key: &str| {
        given.number(&format!("initial_pose.covariance_{key}"), "a number >= 0", |v| v >= 0.0)
    };
    let variances = [covariance("x")?, covariance("y")?, covariance("yaw")?];
    parameters.start_sigmas = variances.map(|found| found.map(|found| found.value.sqrt()));
    for key in ["covariance_xy", "covariance_xyaw", "covariance_yyaw"] {
        let key = format!("initial_pose.{key}");
        let found = given.number(&key, "a number", |_| true)?;
        if let Some(found) = found.filter(|found| found.value.abs() > 0.0) {
            given.warn(found.line, &key, "the start pose has independent deviations");
        }
    }
    if !given.flag("set_initial_pose")?.is_some_and(|set| set.value) {
        let keys = ["x", "y", "z", "yaw"].map(|key| format!("initial_pose.{key}"));
        given.ignore(&keys, "set_initial_pose is not true");
        return Ok(());
    }
    let mut number = |key: &str| given.number(&format!("initial_pose.{key}"), "a number", |_| true);
    let [x, y, yaw, z] = [number("x")?, number("y")?, number("yaw")?, number("z")?];
    if let Some(z) = z.filter(|z| z.value.abs() > 0.0) {
        given.warn(z.line, "initial_pose.z", "the robot drives in the plane");
    }
    let or_zero = |found: Option<Found<f64>>| found.map_or(0.0, |found| found.value);
    parameters.start = Some(Pose2::new(or_zero(x), or_zero(y), or_zero(yaw)));
    Ok(())
}

/// Names of topics and frames, and what only a running robot needs.
fn names(given: &mut NodeParameters, parameters: &mut AmclParameters) -> Result<()> {
    let names = &mut parameters.names;
    for (key, name, reason) in [
        ("scan_topic", &mut names.scan_topic, "a recording has one laser"),
        ("base_frame_id", &mut names.base_frame, "a recording names no frames"),
        ("odom_frame_id", &mut names.odom_frame, "a recording names no frames"),
        ("global_frame_id", &mut names.map_frame, "a recording names no frames"),
    ] {
        if let Some(found) = given.name(key)? {
            parameters.without_bag.push(given.warning(found.line, key, reason));
            *name = Some(found.value);
        }
    }
    given.ignore(&["map_topic"], "the map comes from --map");
    given.ignore(&["transform_tolerance", "tf_broadcast"], "nothing is broadcast");
    given.ignore(&["always_reset_initial_pose"], "a run is never reset");
    given.ignore(&["first_map_only"], "a run has one map");
    given.ignore(&["use_sim_time"], "time is that of the recording");
    given.ignore(&["save_pose_rate"], "every pose is saved");
    Ok(())
}
