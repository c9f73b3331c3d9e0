//! `loc-sim run`: a scenario.

use super::Global;
use super::progress::Progress;
use super::show::{Finished, OutputArgs, show, show_illustration};
use crate::record::Filming;
use crate::runner::Both;
use crate::scenario::{Scenario, builtin};
use std::path::Path;

/// Run a scenario, built in or from a TOML file.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct RunArgs {
    /// Name of a built-in scenario, or a TOML file; `overview` where left out.
    #[arg(value_name = "NAME|FILE.toml")]
    pub scenario: Option<String>,
    /// Another seed than the scenario's.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Print the scenario as TOML instead of running it.
    #[arg(long)]
    pub print_config: bool,
    /// What to run, and where to write it.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Runs a scenario, writes its folder and prints its table.
///
/// # Errors
/// What is wrong with the scenario, and what the run reports.
pub fn run(args: &RunArgs, global: &Global) -> anyhow::Result<()> {
    let name = args.scenario.as_deref().unwrap_or(builtin::DEFAULT);
    let is_file = name.ends_with(".toml") || name.contains(std::path::MAIN_SEPARATOR);
    let text = if is_file {
        std::fs::read_to_string(name).map_err(loc_core::Error::io(name))?
    } else {
        builtin::text(name)?.to_owned()
    };
    if args.print_config {
        return super::print(text.trim_end());
    }
    let changes = &args.output.changes;
    let mut scenario = if is_file {
        Scenario::read(Path::new(name), changes)?
    } else {
        Scenario::named(name, changes)?
    };
    if let Some(threads) = global.threads {
        let filter = scenario.filter.get_or_insert_default();
        filter.mcl.threads = threads;
        filter.landmark_mcl.threads = Some(threads);
        filter.fastslam.threads = Some(threads);
    }
    let seed = args.seed.unwrap_or(scenario.seed);
    if let Some(illustration) = scenario.illustrate(seed)? {
        return show_illustration(&illustration, (&scenario, &text), &args.output, global);
    }
    let methods = &args.output.methods;
    if args.output.smooth {
        scenario.filter.get_or_insert_default().smooth = true;
        let own = scenario.method_list()?;
        args.output.check_smoothing(if methods.is_empty() { &own } else { methods })?;
    }
    let mut progress = Progress::new(&scenario.name, global);
    let methods = (!methods.is_empty()).then_some(methods.as_slice());
    let mut tell = |share| progress.tell(share);
    let mut filming = Filming::new(&mut tell);
    let (mut recorder, target) = args.output.recorder()?;
    let mut watcher = Both(&mut filming, &mut recorder);
    let mut run = scenario.run_watched(Some(seed), methods, &mut watcher)?;
    if let Some((recorder, target)) = recorder.zip(target) {
        target.finish(recorder)?;
    }
    run.film = Some(filming.film);
    progress.finish();
    let finished = Finished {
        run: &run,
        name: &scenario.name,
        title: &scenario.title,
        seed: Some(seed),
        compare: scenario.compare,
        also_in_frame: scenario.also_in_frame.as_deref(),
        scenario: Some(&text),
    };
    show(&finished, &args.output, global)
}
