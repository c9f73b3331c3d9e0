//! `loc-sim study` runs a scenario under many settings and seeds.

use super::Global;
use super::console::Progress;
use super::show::OutputArgs;
use crate::study::{Axis, Study, StudyOptions, StudySource, Success, table};
use anyhow::Context;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Run a scenario under many seeds, and under all combinations of settings.
///
/// Finished runs are kept in the output folder: the same command goes on where it was interrupted.
#[derive(Debug, Clone, clap::Args)]
pub struct StudyArgs {
    /// Name of a built-in scenario, or a TOML file.
    #[arg(value_name = "NAME|FILE.toml")]
    pub scenario: String,
    /// Number of seeds that every combination of settings is run under.
    #[arg(long, value_name = "N", default_value_t = 100)]
    pub runs: u64,
    /// The first of the seeds; the scenario's own where left out.
    #[arg(long, value_name = "FIRST")]
    pub seed: Option<u64>,
    /// A setting and its values: KEY=V1,V2,.. or KEY=FIRST:LAST:COUNT; may be given several times.
    #[arg(long, value_name = "KEY=VALUES")]
    pub vary: Vec<String>,
    /// When a run is a success: FIGURE<LIMIT with a figure of summary.json. Where left out: at the
    /// end within 0.5 m and 10 degrees of the truth.
    #[arg(long, value_name = "FIGURE<LIMIT")]
    pub success: Option<Success>,
    /// Methods, settings and output; out/study-NAME where left out.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// A study was interrupted before it was complete; finished runs are kept.
#[derive(Debug, thiserror::Error)]
#[error("interrupted: {done} of {total} runs are done and kept in {}; the same command goes on", folder.display())]
pub struct Interrupted {
    done: usize,
    total: usize,
    folder: PathBuf,
}

/// Runs a study, writes its folder and prints its tables.
///
/// # Errors
/// Errors of the study, and [`Interrupted`].
pub fn study(args: &StudyArgs, global: &Global) -> anyhow::Result<()> {
    let study = prepare(args)?;
    let name = &study.scenario().name;
    let folder = args.output.out.clone();
    let folder = folder.unwrap_or_else(|| Path::new("out").join(format!("study-{name}")));
    execute(&study, &folder, global)?;
    let results = study.write(&folder, &super::show::command()).with_context(|| {
        format!("cannot write the results; the runs are kept in {}", folder.display())
    })?;
    if global.quiet {
        return Ok(());
    }
    if global.json {
        return super::print(&serde_json::to_string_pretty(&results)?);
    }
    super::print(&table(&results))?;
    super::print(&format!("written to {}", folder.display()))
}

fn prepare(args: &StudyArgs) -> anyhow::Result<Study> {
    let (name, changes) = (args.scenario.as_str(), args.output.changes.as_slice());
    let is_file = name.ends_with(".toml") || name.contains(std::path::MAIN_SEPARATOR);
    let source = match is_file {
        true => StudySource::read(Path::new(name), changes)?,
        false => StudySource::named(name, changes)?,
    };
    let vary = args.vary.iter().map(|text| text.parse()).collect::<crate::Result<Vec<Axis>>>()?;
    let options = StudyOptions {
        runs: args.runs,
        first_seed: args.seed,
        vary,
        methods: args.output.methods.clone(),
        align: args.output.align,
        smooth: args.output.smooth,
        success: args.success.clone().unwrap_or_default(),
        program: program(),
    };
    let study = Study::new(source, options)?;
    args.output.check_smoothing(study.methods())?;
    Ok(study)
}

/// Executes the missing runs.
fn execute(study: &Study, folder: &Path, global: &Global) -> anyhow::Result<()> {
    let stop = on_interrupt()?;
    let cores = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let threads = global.threads.unwrap_or_else(cores);
    let mut progress = Progress::new(&study.scenario().name, global);
    let mut last = None;
    let finished = study.run(folder, threads, &mut |now| {
        if last.is_none() && now.kept > 0 && !global.quiet {
            // Where this cannot be written, the progress bar shows it.
            let _ =
                writeln!(std::io::stderr(), "{} of {} runs were done before", now.kept, now.total);
        }
        last = Some(now);
        progress.update(now.done as f64 / now.total.max(1) as f64);
        !stop.load(Ordering::Relaxed)
    });
    progress.finish();
    let done = last.map_or(0, |now| now.done);
    let kept = || format!("{done} of {} runs are kept in {}", study.grid().len(), folder.display());
    match finished {
        Ok(true) => Ok(()),
        Ok(false) => {
            let total = study.grid().len();
            Err(Interrupted { done, total, folder: folder.into() }.into())
        }
        Err(error) if done > 0 => Err(error).with_context(|| format!("stopped, {}", kept())),
        Err(error) => Err(error.into()),
    }
}

/// A flag that Ctrl-C sets. A second Ctrl-C ends the program at once.
fn on_interrupt() -> anyhow::Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = stop.clone();
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(super::INTERRUPTED.into());
        }
    })
    .context("cannot watch for Ctrl-C")?;
    Ok(stop)
}

/// Version and build of this program: runs of different builds are not mixed, since they need not
/// be the same to the last bit.
fn program() -> String {
    let version = env!("CARGO_PKG_VERSION");
    let bytes = std::env::current_exe().and_then(std::fs::read).unwrap_or_default();
    // The 64-bit FNV-1a hash, over words rather than bytes.
    let hash = bytes.chunks(8).fold(0xcbf2_9ce4_8422_2325_u64, |hash, chunk| {
        let word = chunk.iter().fold(0_u64, |word, byte| word << 8 | u64::from(*byte));
        (hash ^ word).wrapping_mul(0x0100_0000_01b3).rotate_left(23)
    });
    format!("{version} {hash:016x}")
}
