//! Replays of recordings with a laser.

use super::{Format, Replay, ReplayArgs, SEED};
use crate::localizer::{Method, MethodSettings};
use crate::nav2::AmclParameters;
use crate::scenario::{RecordingConfig, StartConfig, recording};
use crate::source::carmen::CarmenLog;
use crate::source::laser_log::{Reference, ReplayOptions, Start};
use crate::source::ros::laser_log;
use crate::source::wean::WeanLog;
use crate::source::{LaserRecording, RosRecording, Source};
use crate::{Result, config};
use loc_core::Pose2;
use loc_maps::LineMap;
use loc_maps::grid::io;
use loc_ros::RosNames;
use std::path::Path;
use std::sync::Arc;

pub(super) fn prepare(args: &ReplayArgs, log: &Path, format: Format) -> anyhow::Result<Replay> {
    let Configuration { settings, mut options, names, without_bag } = configuration(args)?;
    if format != Format::Ros {
        for warning in &without_bag {
            eprintln!("warning: {warning}");
        }
    }
    if let Some(text) = &args.initial_pose {
        options.start = Start::At(parse_pose("--initial-pose", text)?);
    } else if args.global_start || settings.global {
        options.start = Start::Anywhere;
    }
    options.map = args.map.as_ref().map(io::load).transpose()?.map(Arc::new);
    options.lines = args.lines.as_ref().map(LineMap::read_csv).transpose()?.map(Arc::new);
    options.scans = args.scans;
    options.kidnap = args.kidnap;
    options.reference = args.reference.as_deref().map(Reference::read).transpose()?;
    let (source, start_is_known) = source(args, log, format, &options, (&settings, names))?;
    // Odometry alone has nowhere to start where nobody knows the pose.
    let odometry = start_is_known.then_some(Method::DeadReckoning);
    Ok(Replay { source, settings, methods: odometry.into_iter().chain([Method::Mcl]).collect() })
}

/// The recording, and whether anything says where its robot starts.
fn source(
    args: &ReplayArgs,
    log: &Path,
    format: Format,
    options: &ReplayOptions,
    (settings, names): (&MethodSettings, RosNames),
) -> anyhow::Result<(Box<dyn Source>, bool)> {
    let log = match format {
        Format::Ros => {
            let mut ros = args.ros.options(args.seed.unwrap_or(settings.seed))?;
            ros.recording.names = names;
            // A bag is read as a stream, unless the whole of it is needed at once.
            if options.kidnap.is_none() && options.reference.is_none() {
                let source = RosRecording::open(log, options, &ros)?;
                let known = source.start_is_known();
                return Ok((Box::new(source), known));
            }
            laser_log(log, &ros)?
        }
        Format::Wean => WeanLog::open(log)?.laser_log()?,
        _ => CarmenLog::open(log)?.laser_log()?,
    };
    let source = LaserRecording::new(log, options)?;
    let known = source.start_is_known();
    Ok((Box::new(source), known))
}

/// What a configuration says.
struct Configuration {
    settings: MethodSettings,
    options: ReplayOptions,
    /// Of topics and frames, in the parameters of nav2_amcl.
    names: RosNames,
    /// Warnings about them where there is no bag.
    without_bag: Vec<String>,
}

/// What the configuration says, TOML or the parameters of nav2_amcl.
fn configuration(args: &ReplayArgs) -> Result<Configuration> {
    let changes = &args.output.changes;
    let config = match &args.config {
        Some(file) if is_yaml(file) => return parameters(file, changes),
        Some(file) => RecordingConfig::read(file, changes)?,
        None => RecordingConfig::parse("settings for lasers", recording::LASER, changes)?,
    };
    let start_sigmas = config.start.sigmas()?;
    let settings = MethodSettings { seed: SEED, ..config.settings()? };
    let options = ReplayOptions { start_sigmas, ..ReplayOptions::default() };
    Ok(Configuration { settings, options, names: RosNames::default(), without_bag: Vec::new() })
}

/// What a parameter file of nav2_amcl says, with changes of the keys that a TOML file has.
fn parameters(file: &Path, changes: &[String]) -> Result<Configuration> {
    let given = AmclParameters::read(file)?;
    for warning in &given.warnings {
        eprintln!("warning: {warning}");
    }
    let below = |prefix: &str| -> Vec<String> {
        changes.iter().filter_map(|c| c.strip_prefix(prefix)).map(str::to_owned).collect()
    };
    let (of_mcl, of_start) = (below("filter.mcl."), below("start."));
    if of_mcl.len() + of_start.len() < changes.len() {
        let expected = "keys below filter.mcl or start beside a parameter file";
        return Err(config::field("--set", expected, &changes.join(" ")));
    }
    let name = file.display().to_string();
    let mcl = config::changed(&name, given.mcl, &of_mcl)?;
    mcl.validate()?;
    let sigmas = config::changed(&name, StartConfig::default(), &of_start)?.sigmas()?;
    let [x, y, yaw] = given.start_sigmas;
    let options = ReplayOptions {
        start: given.start.map_or(Start::Reference, Start::At),
        start_sigmas: [x.unwrap_or(sigmas[0]), y.unwrap_or(sigmas[1]), yaw.unwrap_or(sigmas[2])],
        ..ReplayOptions::default()
    };
    let seed = given.seed.unwrap_or(SEED);
    let settings = MethodSettings { mcl, seed, ..MethodSettings::default() };
    let AmclParameters { names, without_bag, .. } = given;
    Ok(Configuration { settings, options, names, without_bag })
}

fn is_yaml(file: &Path) -> bool {
    let ending = file.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    ending.is_some_and(|ending| ending == "yaml" || ending == "yml")
}

pub(super) fn parse_pose(option: &str, text: &str) -> Result<Pose2> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, yaw]) if x.is_finite() && y.is_finite() && yaw.is_finite() => {
            Ok(Pose2::new(x, y, yaw))
        }
        _ => Err(config::field(option, "three finite numbers x,y,yaw", text)),
    }
}
