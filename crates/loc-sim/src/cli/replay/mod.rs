//! `loc-sim replay`: a recording.

mod format;
mod landmarks;
mod laser;
mod mrclam;
mod ranging;
mod ros;

pub(super) use format::guess;
pub(super) use landmarks::open as open_landmarks;

pub use format::Format;
pub use ros::RosArgs;

use super::Global;
use super::progress::Progress;
use super::show::{Finished, OutputArgs, show};
use crate::localizer::{Method, MethodSettings};
use crate::record::Filming;
use crate::runner::{self, Both};
use crate::scenario::recording;
use crate::source::Source;
use crate::source::laser_log::Scans;
use anyhow::bail;
use std::path::PathBuf;
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
    /// Do not tell methods that can search where the robot starts.
    #[arg(long = "global")]
    pub global_start: bool,
    /// Carry the robot at least 5 m away, this long after the start.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub kidnap: Option<f64>,
    /// A TUM or CSV file of poses in the map to judge by, in place of those of the log.
    #[arg(long, value_name = "FILE", conflicts_with = "reference_topic")]
    pub reference: Option<PathBuf>,
    /// Seed of the methods that draw random numbers; 1 where nothing says otherwise.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// A TOML file with calibration and settings, or a parameter file of nav2_amcl (.yaml); what
    /// suits the format where left out.
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Print the settings that suit the format as TOML instead of running.
    #[arg(long)]
    pub print_config: bool,
    /// What is said about a bag.
    #[command(flatten)]
    pub ros: RosArgs,
    /// What to run, and where to write it.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Seed where nothing else says one.
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
/// What is wrong with the recording or the settings, and what the run reports.
pub fn replay(args: &ReplayArgs, global: &Global) -> anyhow::Result<()> {
    let log = args.log.as_deref().filter(|_| !args.print_config);
    let Some(log) = log else { return print_config(args) };
    let begin = Instant::now();
    let format = args.format.map_or_else(|| format::guess(log), Ok)?;
    args.ros.refuse_unless(format)?;
    let mut replay = match format {
        Format::Mrclam => mrclam::prepare(args, log)?,
        Format::UwbLabyrinth | Format::Plaza => ranging::prepare(args, log, format)?,
        Format::LandmarkCourse | Format::KfSlamDemo | Format::VictoriaPark => {
            landmarks::prepare(args, log, format)?
        }
        Format::Carmen | Format::Wean | Format::Ros => laser::prepare(args, log, format)?,
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
    let mut tell = |share| progress.tell(share);
    let mut filming = Filming::new(&mut tell);
    let (mut recorder, target) = args.output.recorder()?;
    let mut watcher = Both(&mut filming, &mut recorder);
    let mut run = runner::run_watched(source, methods, &replay.settings, &mut watcher)?;
    if let Some((recorder, target)) = recorder.zip(target) {
        target.finish(recorder)?;
    }
    run.film = Some(filming.film);
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
    let guessed = args.log.as_deref().map(format::guess).transpose()?;
    let format = args.format.or(guessed).unwrap_or(Format::Mrclam);
    let text = match format {
        Format::Mrclam => recording::MRCLAM,
        Format::UwbLabyrinth | Format::Plaza => recording::RANGING,
        Format::LandmarkCourse | Format::KfSlamDemo | Format::VictoriaPark => {
            landmarks::defaults(format)
        }
        Format::Carmen | Format::Wean | Format::Ros => recording::LASER,
    };
    super::print(text.trim_end())
}

/// Refuses options that a format has no use for.
fn refuse(options: &[(&str, bool)], format: &str) -> anyhow::Result<()> {
    match options.iter().find(|(_, given)| *given) {
        Some((option, _)) => bail!("{option}: expected a recording with a laser, got {format}"),
        None => Ok(()),
    }
}
