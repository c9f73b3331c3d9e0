//! Writing and printing a finished run, for `run` and `replay`.

use super::Global;
use super::console::{Unfinished, uninterrupted};
use crate::localizer::Method;
use crate::metrics::{Alignment, Summary};
use crate::output;
use crate::output::mcap::McapRecorder;
use crate::output::{Illustration, Made};
use crate::record::Run;
use crate::scenario::Scenario;
use anyhow::{Context, bail};
use std::path::{Path, PathBuf};

/// The options that `run` and `replay` share.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct OutputArgs {
    /// A method to run; may be given several times.
    #[arg(long = "method", value_name = "M")]
    pub methods: Vec<Method>,
    /// A setting to change; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub changes: Vec<String>,
    /// How estimates are aligned with the frame of the truth before they are compared.
    #[arg(long, value_enum, default_value_t)]
    pub align: Alignment,
    /// An MCAP file of ROS 2 to write beside the folder: map, scans, frames, poses, particles.
    #[arg(long, value_name = "FILE")]
    pub mcap: Option<PathBuf>,
    /// Smooth the estimates of Kalman filters after the run, and show these as well.
    #[arg(long)]
    pub smooth: bool,
    /// The folder to write; out/NAME where left out.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// A finished run with its names and seed.
pub(super) struct Finished<'a> {
    pub(super) run: &'a Run,
    pub(super) name: &'a str,
    pub(super) title: &'a str,
    pub(super) seed: Option<u64>,
    pub(super) compare: bool,
    pub(super) also_in_frame: Option<&'a str>,
    /// The scenario's text; `None` for a recording.
    pub(super) scenario: Option<&'a str>,
}

/// Writes the folder of a run and prints its table.
pub(super) fn show(
    finished: &Finished<'_>,
    args: &OutputArgs,
    global: &Global,
) -> anyhow::Result<()> {
    let run = finished.run;
    let summary = Summary::of(run, finished.seed, args.align)?;
    let command = command();
    let made = Made { command: &command, scenario: finished.scenario };
    let files = output::files(run, &summary, finished.title, made)?;
    let folder = args.folder(finished.name);
    uninterrupted(|| files.write(&folder)).context("cannot write the run")?;
    if global.quiet {
        return Ok(());
    }
    if global.json {
        return super::print(&serde_json::to_string_pretty(&summary)?);
    }
    let table =
        if finished.compare { output::comparison } else { |_: &Run, s: &Summary| output::table(s) };
    super::print(&table(run, &summary))?;
    for line in output::final_beliefs(run, finished.also_in_frame) {
        super::print(&line)?;
    }
    super::print(&format!("written to {}", folder.display()))
}

/// Writes the folder of an illustration and prints its numbers.
pub(super) fn show_illustration(
    illustration: &Illustration,
    (scenario, text): (&Scenario, &str),
    args: &OutputArgs,
    global: &Global,
) -> anyhow::Result<()> {
    let folder = args.folder(&scenario.name);
    let command = command();
    let made = Made { command: &command, scenario: Some(text) };
    let files = illustration.files(&scenario.title, made)?;
    uninterrupted(|| files.write(&folder)).context("cannot write the illustration")?;
    if global.quiet {
        return Ok(());
    }
    if global.json {
        return super::print(&serde_json::to_string_pretty(&illustration.summary)?);
    }
    super::print(&illustration.lines.join("\n"))?;
    super::print(&format!("written to {}", folder.display()))
}

/// The command line.
pub(super) fn command() -> String {
    let arguments = std::env::args().skip(1).collect::<Vec<_>>().join(" ");
    format!("loc-sim {arguments}").trim_end().to_owned()
}

impl OutputArgs {
    /// Refuses smoothing if none of the methods can be smoothed.
    pub(super) fn check_smoothing(&self, methods: &[Method]) -> anyhow::Result<()> {
        if !self.smooth || methods.iter().any(|method| method.can_smooth()) {
            return Ok(());
        }
        let all = Method::ALL.into_iter().filter(|method| method.can_smooth());
        let expected: Vec<&str> = all.map(Method::name).collect();
        let found: Vec<&str> = methods.iter().map(|method| method.name()).collect();
        bail!(
            "--smooth: expected a Kalman filter among the methods ({}), got {}",
            expected.join(", "),
            found.join(", ")
        )
    }

    /// The recorder of the MCAP file and its target, if `--mcap` is given.
    pub(super) fn recorder(&self) -> crate::Result<(Option<McapRecorder>, Option<McapTarget>)> {
        let Some(path) = &self.mcap else { return Ok((None, None)) };
        let target = McapTarget::new(path);
        let recorder = McapRecorder::create(target.written())?;
        Ok((Some(recorder), Some(target)))
    }

    /// The folder to write.
    fn folder(&self, name: &str) -> PathBuf {
        self.out.clone().unwrap_or_else(|| Path::new("out").join(name))
    }
}

/// The MCAP file of a run: until the run is done, it has a temporary name in the same folder.
#[derive(Debug)]
pub(super) struct McapTarget {
    path: PathBuf,
    part: Option<Unfinished>,
}

impl McapTarget {
    fn new(path: &Path) -> Self {
        // A pipe or a device is written directly.
        let is_other = std::fs::metadata(path).is_ok_and(|there| !there.is_file());
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(format!(".{}.part", std::process::id()));
        let part = (!is_other).then(|| Unfinished::new(&path.with_file_name(name)));
        McapTarget { path: path.to_owned(), part }
    }

    fn written(&self) -> &Path {
        self.part.as_ref().map_or(&self.path, Unfinished::path)
    }

    /// Completes the file and renames it to its final name.
    pub(super) fn finish(self, recorder: McapRecorder) -> crate::Result<()> {
        recorder.finish()?;
        if let Some(part) = &self.part {
            std::fs::rename(part.path(), &self.path).map_err(loc_core::Error::io(&self.path))?;
        }
        Ok(())
    }
}
