//! `loc-sim convert` writes a recording in another format.

use super::console::Progress;
use super::replay::{Format, RosArgs, guess, open_landmarks};
use super::{Global, console};
use crate::convert::{Converted, Track, to_carmen, to_mcap, to_tum};
use crate::source::carmen::CarmenLog;
use crate::source::laser_log::{LaserLog, ReplayOptions, Start};
use crate::source::ranging::{RangeRecording, RangingStart};
use crate::source::wean::WeanLog;
use crate::source::{LaserRecording, Mrclam, RosRecording, Source};
use crate::{Error, Result};
use anyhow::bail;
use loc_core::file::write_beside;
use loc_filters::slam::Identities;
use loc_ros::{McapWriter, transcribe};
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// Convert a recording into another format, as far as that format can represent it.
///
/// A bag becomes an MCAP file with its own topics. From other recordings an MCAP file gets /odom,
/// /scan, /tf and /ground_truth.
#[derive(Debug, Clone, clap::Args)]
pub struct ConvertArgs {
    /// The recording, of any format that `replay` knows.
    #[arg(value_name = "LOG")]
    pub log: PathBuf,
    /// The file to write.
    #[arg(value_name = "OUT")]
    pub out: PathBuf,
    /// The target format.
    #[arg(long, value_enum, value_name = "F")]
    pub to: Target,
    /// The format of the recording; found by its contents where left out.
    #[arg(long, value_name = "F")]
    pub format: Option<Format>,
    /// Number of the robot, in recordings of several.
    #[arg(long, value_name = "K", default_value_t = 1)]
    pub robot: u32,
    /// The track for a TUM file; the reference where there is one, if left out.
    #[arg(long, value_enum, value_name = "T")]
    pub track: Option<Track>,
    /// Options for bags.
    #[command(flatten)]
    pub ros: RosArgs,
}

/// A format to write.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Target {
    /// An MCAP file of ROS 2.
    Mcap,
    /// A CARMEN log.
    Carmen,
    /// One track, a line `t x y z qx qy qz qw` a pose.
    Tum,
}

/// Converts a recording and reports what was written and what was left out.
///
/// # Errors
/// Errors of the recording and of the operating system; OUT is then unchanged.
pub fn convert(args: &ConvertArgs, global: &Global) -> anyhow::Result<()> {
    let (log, out) = (args.log.as_path(), args.out.as_path());
    let format = args.format.map_or_else(|| guess(log), Ok)?;
    if args.track.is_some() && args.to != Target::Tum {
        bail!("--track: expected --to tum, which holds one track, got another format");
    }
    let same = |a: &Path, b: &Path| a.canonicalize().ok().zip(b.canonicalize().ok());
    if same(log, out).is_some_and(|(log, out)| log == out) {
        bail!("{}: expected another file to write to than the recording", out.display());
    }
    args.ros.refuse_unless(format)?;
    let mut progress = Progress::new("convert", global);
    let mut update = |share| progress.update(share);
    let mut write = |part: &Path| match (args.to, format) {
        (Target::Mcap, Format::Ros) => {
            let mut bag = loc_ros::open(log)?;
            let writer = McapWriter::create(part)?;
            Ok(transcribe(bag.as_mut(), writer, &mut update)?.into())
        }
        (Target::Mcap, _) => to_mcap(open(args, format)?.as_mut(), part, &mut update),
        (Target::Carmen, _) => {
            let file = File::create(part).map_err(loc_core::Error::io(part))?;
            to_carmen(open(args, format)?.as_mut(), BufWriter::new(file), out, &mut update)
        }
        (Target::Tum, _) => {
            let (track, converted) = to_tum(open(args, format)?.as_mut(), args.track, &mut update)?;
            std::fs::write(part, track.to_tum()).map_err(loc_core::Error::io(out))?;
            Ok::<_, Error>(converted)
        }
    };
    let converted = write_beside(out, |part| console::filling(part, || write(part)))?;
    progress.finish();
    report(&converted, args, global)
}

fn report(converted: &Converted, args: &ConvertArgs, global: &Global) -> anyhow::Result<()> {
    if global.quiet {
        return Ok(());
    }
    if global.json {
        return super::print(&serde_json::to_string_pretty(converted)?);
    }
    let what = match args.to {
        Target::Mcap => "messages",
        Target::Carmen => "lines",
        Target::Tum => "poses",
    };
    let mut lines = vec![format!("{} {what} written to {}", converted.written, args.out.display())];
    lines.extend(converted.left_out.iter().map(|line| format!("note: {line}")));
    super::print(&lines.join("\n"))
}

/// The recording as a stream.
fn open(args: &ConvertArgs, format: Format) -> Result<Box<dyn Source>> {
    let log = args.log.as_path();
    let options = ReplayOptions { start: Start::Anywhere, ..ReplayOptions::default() };
    let replayed = |log: LaserLog| LaserRecording::new(log, &options);
    Ok(match format {
        Format::Ros => {
            Box::new(RosRecording::open(log, &options, &args.ros.with_original_stamps(0)?)?)
        }
        Format::Carmen => Box::new(replayed(CarmenLog::open(log)?.laser_log()?)?),
        Format::Wean => Box::new(replayed(WeanLog::open(log)?.laser_log()?)?),
        Format::Mrclam => Box::new(Mrclam::open(log, args.robot)?),
        Format::UwbLabyrinth => Box::new(RangeRecording::labyrinth(log, &RangingStart::default())?),
        Format::LandmarkCourse | Format::KfSlamDemo | Format::VictoriaPark => {
            Box::new(open_landmarks(log, format, Identities::Known, [0.0; 3])?)
        }
        Format::Plaza => {
            Box::new(RangeRecording::plaza(log, args.robot, &RangingStart::default())?)
        }
    })
}
