//! `loc-sim replay`: a recording.

use super::Global;
use super::progress::Progress;
use super::show::{Finished, OutputArgs, show};
use crate::localizer::Method;
use crate::runner;
use crate::scenario::{RecordingConfig, recording};
use crate::source::{Calibrated, Mrclam, mrclam};
use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// Localize the robot of a recording.
#[derive(Debug, Clone, clap::Args)]
pub struct ReplayArgs {
    /// The recording: a folder of MRCLAM files.
    #[arg(value_name = "LOG", required_unless_present = "print_config")]
    pub log: Option<PathBuf>,
    /// The format of the recording; found by its files where left out.
    #[arg(long, value_name = "F")]
    pub format: Option<Format>,
    /// Number of the robot, in recordings of several.
    #[arg(long, value_name = "K", default_value_t = 1)]
    pub robot: u32,
    /// A TOML file with calibration and settings; what suits the format where left out.
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Print the settings that suit the format as TOML instead of running.
    #[arg(long)]
    pub print_config: bool,
    /// What to run, and where to write it.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// A format of recordings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
#[non_exhaustive]
pub enum Format {
    /// A folder of the UTIAS MRCLAM data set.
    Mrclam,
}

/// Runs methods over a recording, writes the folder and prints the table.
///
/// # Errors
/// What is wrong with the recording or the settings, and what the run reports.
pub fn replay(args: &ReplayArgs, global: &Global) -> anyhow::Result<()> {
    let Some(log) = args.log.as_deref().filter(|_| !args.print_config) else {
        return super::print(recording::MRCLAM.trim_end());
    };
    let format = args.format.map_or_else(|| guess(log), Ok)?;
    let config = match &args.config {
        Some(file) => RecordingConfig::read(file, &args.output.changes)?,
        None => match format {
            Format::Mrclam => RecordingConfig::parse(
                "settings for mrclam",
                recording::MRCLAM,
                &args.output.changes,
            )?,
        },
    };
    let source = match format {
        Format::Mrclam => Mrclam::open(log, args.robot)?,
    };
    let mut source =
        Calibrated::new(source, config.odometry_calibration(), config.camera_calibration())?;
    let methods = match args.output.methods.as_slice() {
        [] => &[Method::DeadReckoning, Method::Ekf],
        given => given,
    };
    let mut progress = Progress::new("replay", global);
    let run = runner::run(&mut source, methods, &config.settings()?, &mut |share| {
        progress.tell(share);
    })?;
    progress.finish();
    let name = run.setup.name.replace(' ', "-");
    let finished = Finished {
        run: &run,
        name: &name,
        title: &run.setup.name,
        seed: None,
        also_in_frame: None,
    };
    show(&finished, &args.output, global)
}

/// The format of a recording, by its files.
fn guess(log: &Path) -> Result<Format> {
    std::fs::metadata(log).map_err(loc_core::Error::io(log))?;
    if mrclam::is_mrclam(log) {
        return Ok(Format::Mrclam);
    }
    Err(Error::Recording {
        path: log.to_owned(),
        expected: "a recording: a folder with Barcodes.dat (mrclam)".into(),
        found: if log.is_dir() { "a folder without it" } else { "a file" }.into(),
    })
}
