//! The recording that `loc-sim replay` runs on, its settings and its default methods, by format.

use super::{Format, Replay, ReplayArgs, SEED, refuse};
use crate::localizer::{Method, MethodSettings};
use crate::nav2::AmclParameters;
use crate::scenario::{RecordingConfig, recording};
use crate::source::carmen::CarmenLog;
use crate::source::landmarks::Trees;
use crate::source::laser_log::{Reference, ReplayOptions, Scans, Start};
use crate::source::ranging::{RangeRecording, RangingStart};
use crate::source::ros::{OdometryDelay, RosOptions, laser_log};
use crate::source::wean::WeanLog;
use crate::source::{Calibrated, LandmarkRecording, LaserRecording, Mrclam, RosRecording, Source};
use crate::{Result, config};
use anyhow::bail;
use loc_core::Pose2;
use loc_core::error::finite;
use loc_core::motion::VelocityNoise;
use loc_filters::RobotSettings;
use loc_filters::slam::Identities;
use loc_maps::LineMap;
use loc_maps::grid::io;
use loc_ros::{RecordingOptions, RosNames};
use std::path::Path;
use std::sync::Arc;

/// A recording with a laser: CARMEN, Wean Hall, or a bag.
pub(super) fn laser(args: &ReplayArgs, log: &Path, format: Format) -> anyhow::Result<Replay> {
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
    let (source, start_is_known) = laser_source(args, log, format, &options, (&settings, names))?;
    // Dead reckoning needs a start pose.
    let odometry = start_is_known.then_some(Method::DeadReckoning);
    Ok(Replay { source, settings, methods: odometry.into_iter().chain([Method::Mcl]).collect() })
}

/// The recording, and whether its start pose is known.
fn laser_source(
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
            // A bag is read as a stream, unless kidnapping or a reference need it as a whole.
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

/// Refuses a calibration of odometry or camera, which only recordings of MRCLAM have.
fn refuse_calibration(config: &RecordingConfig) -> Result<()> {
    let own = RecordingConfig::default();
    for (key, is_given) in
        [("odometry", config.odometry != own.odometry), ("camera", config.camera != own.camera)]
    {
        if is_given {
            let found = "one for another format";
            return Err(config::field(key, "a calibration for MRCLAM alone", found));
        }
    }
    Ok(())
}

/// The content of a configuration.
struct Configuration {
    settings: MethodSettings,
    options: ReplayOptions,
    /// Names of topics and frames, from the parameters of nav2_amcl.
    names: RosNames,
    /// Warnings about them where there is no bag.
    without_bag: Vec<String>,
}

/// Reads the configuration, TOML or the parameters of nav2_amcl.
fn configuration(args: &ReplayArgs) -> Result<Configuration> {
    let changes = &args.output.changes;
    let config = match &args.config {
        Some(file) if is_yaml(file) => return parameters(file, changes),
        Some(file) => RecordingConfig::read(file, changes)?,
        None => RecordingConfig::parse("settings for lasers", recording::LASER, changes)?,
    };
    refuse_calibration(&config)?;
    let start_sigmas = config.start_sigma.sigmas()?;
    let settings = MethodSettings { seed: SEED, ..config.settings(RobotSettings::default())? };
    let options = ReplayOptions { start_sigmas, ..ReplayOptions::default() };
    Ok(Configuration { settings, options, names: RosNames::default(), without_bag: Vec::new() })
}

/// Reads a parameter file of nav2_amcl, with changes of keys of the TOML form.
fn parameters(file: &Path, changes: &[String]) -> Result<Configuration> {
    let given = AmclParameters::read(file)?;
    for warning in &given.warnings {
        eprintln!("warning: {warning}");
    }
    let name = file.display().to_string();
    let config = RecordingConfig::parse(&name, recording::LASER, changes)?;
    refuse_calibration(&config)?;
    let sigmas = config.start_sigma.sigmas()?;
    let [x, y, yaw] = given.start_sigmas;
    let options = ReplayOptions {
        start: given.start.map_or(Start::Reference, Start::At),
        start_sigmas: [x.unwrap_or(sigmas[0]), y.unwrap_or(sigmas[1]), yaw.unwrap_or(sigmas[2])],
        ..ReplayOptions::default()
    };
    let seed = given.seed.unwrap_or(SEED);
    let own = MethodSettings { mcl: given.mcl, seed, ..MethodSettings::default() };
    let settings = own.overlaid(&config.filter)?;
    let AmclParameters { names, without_bag, .. } = given;
    Ok(Configuration { settings, options, names, without_bag })
}

/// The settings that a parameter file of nav2_amcl gives, as TOML.
pub(super) fn from_parameters(file: &Path, changes: &[String]) -> Result<String> {
    parameters(file, changes)?.settings.to_toml()
}

pub(super) fn is_yaml(file: &Path) -> bool {
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

/// A recording of landmarks without a map of them, for SLAM.
pub(super) fn landmarks(args: &ReplayArgs, log: &Path, format: Format) -> anyhow::Result<Replay> {
    let given = [
        ("--map", args.map.is_some()),
        ("--lines", args.lines.is_some()),
        ("--scans", args.scans != Scans::All),
        ("--initial-pose", args.initial_pose.is_some()),
        ("--kidnap", args.kidnap.is_some()),
        ("--reference", args.reference.is_some()),
    ];
    refuse(&given, "one of landmarks")?;
    let changes = &args.output.changes;
    let parse = |text| RecordingConfig::parse("settings for landmarks", text, changes);
    let config = match &args.config {
        Some(file) => RecordingConfig::read(file, changes)?,
        None => match parse(landmark_defaults(format))? {
            config if format == Format::VictoriaPark && without_numbers(&config)? => {
                parse(recording::VICTORIA_PARK_DETECTIONS)?
            }
            config => config,
        },
    };
    refuse_calibration(&config)?;
    let identities = config.settings(RobotSettings::default())?.slam.identities;
    let source = open_landmarks(log, format, identities, config.start_sigma.sigmas()?)?;
    let robot = RobotSettings::default().mounting(source.mounting());
    let settings = MethodSettings { seed: SEED, ..config.settings(robot)? };
    Ok(Replay {
        source: Box::new(source),
        settings,
        methods: vec![Method::DeadReckoning, Method::EkfSlam],
    })
}

fn without_numbers(config: &RecordingConfig) -> Result<bool> {
    let settings = config.settings(RobotSettings::default())?;
    Ok(settings.slam.identities == Identities::Unknown)
}

/// The settings that suit a format.
pub(super) fn landmark_defaults(format: Format) -> &'static str {
    match format {
        Format::LandmarkCourse => recording::LANDMARK_COURSE,
        Format::KfSlamDemo => recording::KF_SLAM_DEMO,
        _ => recording::VICTORIA_PARK,
    }
}

/// Opens a recording of one of these formats; of Victoria Park, the data that match `identities`.
pub(in crate::cli) fn open_landmarks(
    log: &Path,
    format: Format,
    identities: Identities,
    sigmas: [f64; 3],
) -> Result<LandmarkRecording> {
    let trees = match identities {
        Identities::Known => Trees::Numbered,
        Identities::Unknown => Trees::Detected,
    };
    match format {
        Format::LandmarkCourse => LandmarkRecording::course(log, sigmas),
        Format::KfSlamDemo => LandmarkRecording::kf_slam_demo(log, sigmas),
        _ => LandmarkRecording::victoria_park(log, trees, sigmas),
    }
}

/// A recording of ranges to beacons.
pub(super) fn ranging(args: &ReplayArgs, log: &Path, format: Format) -> anyhow::Result<Replay> {
    let given = [
        ("--map", args.map.is_some()),
        ("--scans", args.scans != Scans::All),
        ("--kidnap", args.kidnap.is_some()),
        ("--reference", args.reference.is_some()),
    ];
    refuse(&given, "one of ranges")?;
    let changes = &args.output.changes;
    let config = match &args.config {
        Some(file) => RecordingConfig::read(file, changes)?,
        None => RecordingConfig::parse("settings for ranging", recording::RANGING, changes)?,
    };
    refuse_calibration(&config)?;
    let pose =
        args.initial_pose.as_deref().map(|text| parse_pose("--initial-pose", text)).transpose()?;
    let start = RangingStart { pose, sigmas: config.start_sigma.sigmas()? };
    let source = match format {
        Format::Plaza => RangeRecording::plaza(log, args.robot, &start)?,
        _ => RangeRecording::labyrinth(log, &start)?,
    };
    let robot = RobotSettings::default().camera(source.noise());
    let settings = MethodSettings { seed: SEED, ..config.settings(robot)? };
    let odometry = (!args.global_start && !settings.global).then_some(Method::DeadReckoning);
    Ok(Replay {
        source: Box::new(source),
        settings,
        methods: odometry.into_iter().chain([Method::Lateration, Method::Fusion]).collect(),
    })
}

/// A recording of MRCLAM.
pub(super) fn mrclam(args: &ReplayArgs, log: &Path) -> anyhow::Result<Replay> {
    let given = [
        ("--map", args.map.is_some()),
        ("--lines", args.lines.is_some()),
        ("--scans", args.scans != Scans::All),
        ("--initial-pose", args.initial_pose.is_some()),
        ("--kidnap", args.kidnap.is_some()),
        ("--reference", args.reference.is_some()),
    ];
    refuse(&given, "one of MRCLAM")?;
    let changes = &args.output.changes;
    let config = match &args.config {
        Some(file) => RecordingConfig::read(file, changes)?,
        None => RecordingConfig::parse("settings for mrclam", recording::MRCLAM, changes)?,
    };
    let source = Mrclam::open(log, args.robot)?;
    let source = Calibrated::new(source, config.odometry, config.camera)?;
    Ok(Replay {
        source: Box::new(source),
        settings: MethodSettings { seed: SEED, ..config.settings(RobotSettings::default())? },
        methods: vec![Method::DeadReckoning, Method::Ekf],
    })
}

/// Options for bags: topics and properties that are not found in the bag.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct RosArgs {
    /// The topic with the scans, in a bag with several.
    #[arg(long, value_name = "TOPIC")]
    pub scan_topic: Option<String>,
    /// The topic with the odometry, in a bag with several.
    #[arg(long, value_name = "TOPIC")]
    pub odom_topic: Option<String>,
    /// The topic of a bag with true poses; `/tf` for the recorded transform from map, `none` for
    /// no reference. Found by its name where left out.
    #[arg(long, value_name = "TOPIC")]
    pub reference_topic: Option<String>,
    /// The topic of the inertial unit, in a bag with several; `none` to leave it out.
    #[arg(long, value_name = "TOPIC")]
    pub imu_topic: Option<String>,
    /// The topic of the satellite receiver, in a bag with several; `none` to leave it out.
    #[arg(long, value_name = "TOPIC")]
    pub fix_topic: Option<String>,
    /// Where the laser sits on the robot, in metres and radians, in place of what a bag says.
    #[arg(long, value_name = "X,Y,YAW", allow_hyphen_values = true)]
    pub laser_mounting: Option<String>,
    /// How much later than its stamp the robot was where its odometry says, in seconds; negative
    /// for an odometry that comes late, 0 for stamps as they are. Estimated from the turns of the
    /// scans where left out.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub odom_delay: Option<f64>,
    /// Noise to add to the odometry of a bag, as standard deviations: of the distance \[m\] after
    /// 1 m, of the heading \[deg\] after a full turn, and of the heading \[deg\] after 1 m.
    #[arg(long, value_name = "DISTANCE,TURN,DRIFT")]
    pub odom_noise: Option<String>,
}

impl RosArgs {
    /// The library's form.
    pub(in crate::cli) fn options(&self, seed: u64) -> Result<RosOptions> {
        let pose = |text: &String| parse_pose("--laser-mounting", text);
        let known = self.odom_delay.map(|delay| finite("--odom-delay [s]", delay)).transpose()?;
        let noise = |text: &String| Ok::<_, crate::Error>((parse_noise(text)?, seed));
        let recording = RecordingOptions {
            scan_topic: self.scan_topic.clone(),
            odom_topic: self.odom_topic.clone(),
            reference_topic: self.reference_topic.clone(),
            names: RosNames::default(),
            imu_topic: self.imu_topic.clone(),
            fix_topic: self.fix_topic.clone(),
            mounting: self.laser_mounting.as_ref().map(pose).transpose()?,
            odometry_delay: known.unwrap_or(0.0),
            odometry_noise: self.odom_noise.as_ref().map(noise).transpose()?,
        };
        let delay = if known.is_some() { OdometryDelay::Known } else { OdometryDelay::Estimated };
        Ok(RosOptions { recording, odometry_delay: delay })
    }

    /// The library's form, without an estimated delay of the odometry: stamps stay as they are
    /// unless a delay is given.
    pub(in crate::cli) fn with_original_stamps(&self, seed: u64) -> Result<RosOptions> {
        let options = self.options(seed)?;
        Ok(RosOptions { odometry_delay: OdometryDelay::Known, ..options })
    }

    /// Refuses options of bags for every other format.
    pub(in crate::cli) fn refuse_unless(&self, format: Format) -> anyhow::Result<()> {
        let options = [
            ("--scan-topic", self.scan_topic.is_some()),
            ("--odom-topic", self.odom_topic.is_some()),
            ("--reference-topic", self.reference_topic.is_some()),
            ("--imu-topic", self.imu_topic.is_some()),
            ("--fix-topic", self.fix_topic.is_some()),
            ("--laser-mounting", self.laser_mounting.is_some()),
            ("--odom-delay", self.odom_delay.is_some()),
            ("--odom-noise", self.odom_noise.is_some()),
        ];
        match options.iter().find(|(_, given)| *given) {
            Some((option, _)) if format != Format::Ros => {
                bail!("{option}: expected a bag of ROS, got another recording")
            }
            _ => Ok(()),
        }
    }
}

fn parse_noise(text: &str) -> Result<VelocityNoise> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[distance, turn, drift]) => {
            Ok(VelocityNoise::from_sigmas(distance, turn.to_radians(), drift.to_radians())?)
        }
        _ => Err(config::field("--odom-noise", "three numbers distance,turn,drift", text)),
    }
}
