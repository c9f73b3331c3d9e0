//! `loc-sim replay` runs methods over a recording.

mod source;

pub use source::RosArgs;
pub(super) use source::open_landmarks;

use super::Global;
use super::console::Progress;
use super::show::{Finished, OutputArgs, show};
use crate::localizer::{Method, MethodSettings};
use crate::record::PlaybackRecorder;
use crate::runner::Observers;
use crate::scenario::{RecordingConfig, recording};
use crate::source::landmarks::{kf_slam_demo, victoria_park};
use crate::source::laser_log::Scans;
use crate::source::ranging::{labyrinth, plaza};
use crate::source::{Source, landmarks, mrclam, text};
use crate::{Error, Result, runner};
use anyhow::bail;
use loc_filters::RobotSettings;
use std::io::{BufRead, Read};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Localize the robot of a recording.
#[derive(Debug, Clone, clap::Args)]
pub struct ReplayArgs {
    /// The recording: a bag of ROS 1 or 2, an MCAP file, a folder of MRCLAM files, of ranges (UWB
    /// labyrinth, Plaza) or of landmarks (landmark course, MRPT's kf-slam demo, Victoria Park), a
    /// CARMEN log, or one of Wean Hall.
    #[arg(value_name = "LOG", required_unless_present = "print_config")]
    pub log: Option<PathBuf>,
    /// The format of the recording; found by its contents where left out.
    #[arg(long, value_name = "F")]
    pub format: Option<Format>,
    /// Number of the robot, in recordings of several.
    #[arg(long, value_name = "K", default_value_t = 1)]
    pub robot: u32,
    /// The map to localize a laser in.
    #[arg(long, value_name = "MAP")]
    pub map: Option<PathBuf>,
    /// The walls as lines (x1 y1 x2 y2), for methods that match them; found in the map where left
    /// out.
    #[arg(long, value_name = "FILE")]
    pub lines: Option<PathBuf>,
    /// Which scans to use, counted from 0.
    #[arg(long, value_enum, default_value_t = Scans::All)]
    pub scans: Scans,
    /// Start pose in the map, in metres and radians; where the reference starts if left out.
    #[arg(
        long,
        value_name = "X,Y,YAW",
        allow_hyphen_values = true,
        conflicts_with = "global_start"
    )]
    pub initial_pose: Option<String>,
    /// Start without a pose, for methods that can search the whole map.
    #[arg(long = "global")]
    pub global_start: bool,
    /// Kidnap the robot this long after the start: cut out the log until it is at least 5 m away.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub kidnap: Option<f64>,
    /// A TUM or CSV file of reference poses in the map, in place of those of the log.
    #[arg(long, value_name = "FILE", conflicts_with = "reference_topic")]
    pub reference: Option<PathBuf>,
    /// Seed of the methods that draw random numbers; 1 unless the configuration has another.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// A TOML file with calibration and settings, or a parameter file of nav2_amcl (.yaml); what
    /// suits the format where left out.
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Print the settings that suit the format as TOML instead of running, with all settings in
    /// effect as comments.
    #[arg(long)]
    pub print_config: bool,
    /// Options for bags.
    #[command(flatten)]
    pub ros: RosArgs,
    /// Methods, settings and output.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Default seed.
const SEED: u64 = 1;

/// A recording, ready to be run.
struct Replay {
    source: Box<dyn Source>,
    settings: MethodSettings,
    /// The methods that run where none is named.
    methods: Vec<Method>,
}

/// Runs methods over a recording, writes the folder and prints the table.
///
/// # Errors
/// Errors of the recording, the settings or the run.
pub fn replay(args: &ReplayArgs, global: &Global) -> anyhow::Result<()> {
    let log = args.log.as_deref().filter(|_| !args.print_config);
    let Some(log) = log else { return print_config(args) };
    let begin = Instant::now();
    let format = args.format.map_or_else(|| guess(log), Ok)?;
    args.ros.refuse_unless(format)?;
    let mut replay = match format {
        Format::Mrclam => source::mrclam(args, log)?,
        Format::UwbLabyrinth | Format::Plaza => source::ranging(args, log, format)?,
        Format::LandmarkCourse | Format::KfSlamDemo | Format::VictoriaPark => {
            source::landmarks(args, log, format)?
        }
        Format::Carmen | Format::Wean | Format::Ros => source::laser(args, log, format)?,
    };
    replay.settings.seed = args.seed.unwrap_or(replay.settings.seed);
    replay.settings.global |= args.global_start;
    if let Some(threads) = global.threads {
        replay.settings.mcl.threads = threads;
        replay.settings.landmark_mcl.threads = threads;
        replay.settings.fastslam.threads = threads;
    }
    let methods = match args.output.methods.as_slice() {
        [] => replay.methods.as_slice(),
        given => given,
    };
    replay.settings.smooth |= args.output.smooth;
    args.output.check_smoothing(methods)?;
    let mut progress = Progress::new("replay", global);
    let source = replay.source.as_mut();
    let mut update = |share| progress.update(share);
    let mut playback = PlaybackRecorder::new(&mut update);
    let (mut recorder, target) = args.output.recorder()?;
    let mut observer = Observers(&mut playback, &mut recorder);
    let mut run = runner::run_observed(source, methods, &replay.settings, &mut observer)?;
    if let Some((recorder, target)) = recorder.zip(target) {
        target.finish(recorder)?;
    }
    run.playback = Some(playback.playback);
    progress.finish();
    let took = begin.elapsed().as_secs_f64();
    let name = run.setup.name.replace(' ', "-");
    let finished = Finished {
        run: &run,
        name: &name,
        title: &run.setup.name,
        seed: methods.iter().any(|method| method.draws()).then_some(replay.settings.seed),
        compare: false,
        also_in_frame: None,
        scenario: None,
    };
    show(&finished, &args.output, global)?;
    if global.quiet || global.json {
        return Ok(());
    }
    super::print(&speed(run.duration(), took))
}

/// How fast the replay was, from the opening of the recording to the end of the run.
fn speed(duration: f64, took: f64) -> String {
    let factor = duration / took.max(1e-9);
    format!("replayed {duration:.1} s in {took:.2} s, {factor:.0} times as fast as it was")
}

fn print_config(args: &ReplayArgs) -> anyhow::Result<()> {
    let guessed = args.log.as_deref().map(guess).transpose()?;
    let format = args.format.or(guessed).unwrap_or(Format::Mrclam);
    let text = match format {
        Format::Mrclam => recording::MRCLAM,
        Format::UwbLabyrinth | Format::Plaza => recording::RANGING,
        Format::LandmarkCourse | Format::KfSlamDemo | Format::VictoriaPark => {
            source::landmark_defaults(format)
        }
        Format::Carmen | Format::Wean | Format::Ros => recording::LASER,
    };
    let (name, text) = match &args.config {
        Some(file) if source::is_yaml(file) => {
            return super::print(source::from_parameters(file, &args.output.changes)?.trim_end());
        }
        Some(file) => {
            let text = std::fs::read_to_string(file).map_err(loc_core::Error::io(file))?;
            (file.display().to_string(), text)
        }
        None => ("settings of the format".to_owned(), text.to_owned()),
    };
    let config = RecordingConfig::parse(&name, &text, &args.output.changes)?;
    let settings = config.settings(RobotSettings::default())?;
    super::print(&super::with_effective(&text, &settings)?)
}

/// Refuses options that a format has no use for.
fn refuse(options: &[(&str, bool)], format: &str) -> anyhow::Result<()> {
    match options.iter().find(|(_, given)| *given) {
        Some((option, _)) => bail!("{option}: expected a recording with a laser, got {format}"),
        None => Ok(()),
    }
}

/// A format of recordings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
#[non_exhaustive]
pub enum Format {
    /// A folder of the UTIAS MRCLAM data set.
    Mrclam,
    /// A folder of ultra-wideband ranges in the format of libRSF.
    UwbLabyrinth,
    /// A folder of the Plaza recordings: radio ranges and odometry.
    Plaza,
    /// A folder of the Freiburg landmark course.
    LandmarkCourse,
    /// MRPT's demonstration of SLAM as text: its folder, or its file of observations.
    KfSlamDemo,
    /// A folder of Victoria Park.
    VictoriaPark,
    /// A CARMEN log.
    Carmen,
    /// A log of CMU's Wean Hall.
    Wean,
    /// A bag of ROS 1 or ROS 2, or an MCAP file.
    Ros,
}

/// First words of lines that only a CARMEN log has.
const CARMEN: [&str; 9] = [
    "PARAM",
    "ODOM",
    "FLASER",
    "RLASER",
    "ROBOTLASER1",
    "ROBOTLASER2",
    "RAWLASER1",
    "TRUEPOS",
    "SYNC",
];

/// The format of a recording, by its files or its first lines.
pub(in crate::cli) fn guess(log: &Path) -> Result<Format> {
    std::fs::metadata(log).map_err(loc_core::Error::io(log))?;
    if mrclam::is_mrclam(log) {
        return Ok(Format::Mrclam);
    }
    if labyrinth::is_labyrinth(log) {
        return Ok(Format::UwbLabyrinth);
    }
    if plaza::is_plaza(log) {
        return Ok(Format::Plaza);
    }
    if landmarks::is_course(log) {
        return Ok(Format::LandmarkCourse);
    }
    if victoria_park::is_victoria_park(log) {
        return Ok(Format::VictoriaPark);
    }
    if kf_slam_demo::is_kf_slam_demo(log) {
        return Ok(Format::KfSlamDemo);
    }
    if loc_ros::is_bag(log)? {
        return Ok(Format::Ros);
    }
    if log.is_dir() {
        return Err(unknown(log, "a folder without any of these"));
    }
    // Comments and other messages may come before the first line that identifies the format.
    for line in text::open(log)?.take(1 << 20).split(b'\n').take(1000) {
        let line = line.map_err(loc_core::Error::io(log))?;
        let line = String::from_utf8_lossy(&line);
        match line.split_ascii_whitespace().next() {
            Some("O" | "L") => return Ok(Format::Wean),
            Some(word) if CARMEN.contains(&word) => return Ok(Format::Carmen),
            _ => {}
        }
    }
    Err(unknown(log, "a file of another kind"))
}

fn unknown(log: &Path, found: &str) -> Error {
    Error::Recording {
        path: log.to_owned(),
        expected: "a recording: a bag of ROS, an MCAP file, a folder with Barcodes.dat (mrclam), \
                   a file *_Input.txt (uwb-labyrinth), plaza1_ranges.csv (plaza), sensor_data.dat \
                   (landmark-course), *_bearing_range.csv (kf-slam-demo) or \
                   gtsam_landmark_obs.csv (victoria-park), a log of ODOM and FLASER lines \
                   (carmen), or of O and L lines (wean)"
            .into(),
        found: found.into(),
    }
}
