//! `loc-sim run` runs a scenario, `loc-sim list` lists the built-in ones.

use super::Global;
use super::console::Progress;
use super::show::{Finished, OutputArgs, show, show_illustration};
use crate::record::PlaybackRecorder;
use crate::runner::Observers;
use crate::scenario::{Scenario, builtin};
use std::path::Path;

/// Run a scenario, built in or from a TOML file.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct RunArgs {
    /// Name of a built-in scenario, or a TOML file; `overview` where left out.
    #[arg(value_name = "NAME|FILE.toml")]
    pub scenario: Option<String>,
    /// Seed, in place of the scenario's.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Print the scenario as TOML instead of running it, with all settings in effect as comments.
    #[arg(long)]
    pub print_config: bool,
    /// Methods, settings and output.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Runs a scenario, writes its folder and prints its table.
///
/// # Errors
/// Errors of the scenario and of the run.
pub fn run(args: &RunArgs, global: &Global) -> anyhow::Result<()> {
    let name = args.scenario.as_deref().unwrap_or(builtin::DEFAULT);
    let is_file = name.ends_with(".toml") || name.contains(std::path::MAIN_SEPARATOR);
    let text = if is_file {
        std::fs::read_to_string(name).map_err(loc_core::Error::io(name))?
    } else {
        builtin::text(name)?.to_owned()
    };
    let changes = &args.output.changes;
    let mut scenario = if is_file {
        Scenario::read(Path::new(name), changes)?
    } else {
        Scenario::named(name, changes)?
    };
    scenario.threads = global.threads;
    if args.print_config {
        let settings = scenario.settings()?;
        let has_methods = !scenario.methods.is_empty();
        let all = if has_methods { super::with_effective(&text, &settings)? } else { text };
        return super::print(all.trim_end());
    }
    let seed = args.seed.unwrap_or(scenario.seed);
    if let Some(illustration) = scenario.illustrate(seed)? {
        return show_illustration(&illustration, (&scenario, &text), &args.output, global);
    }
    let methods = &args.output.methods;
    if args.output.smooth {
        scenario.filter.insert("smooth".into(), true.into());
        let own = scenario.method_list()?;
        args.output.check_smoothing(if methods.is_empty() { &own } else { methods })?;
    }
    let mut progress = Progress::new(&scenario.name, global);
    let methods = (!methods.is_empty()).then_some(methods.as_slice());
    let mut update = |share| progress.update(share);
    let mut playback = PlaybackRecorder::new(&mut update);
    let (mut recorder, target) = args.output.recorder()?;
    let mut observer = Observers(&mut playback, &mut recorder);
    let mut run = scenario.run_observed(Some(seed), methods, &mut observer)?;
    if let Some((recorder, target)) = recorder.zip(target) {
        target.finish(recorder)?;
    }
    run.playback = Some(playback.playback);
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

/// List the built-in scenarios, or the scenario that shows each of the lectures' IDs.
#[derive(Debug, Clone, clap::Args)]
pub struct ListArgs {
    /// A line for each ID: the scenario that shows it, and the figure to look at.
    #[arg(long)]
    pub ids: bool,
}

/// Prints name, title and IDs of every built-in scenario, or the IDs with their scenarios.
///
/// # Errors
/// Those of standard output.
pub fn list(args: &ListArgs, global: &Global) -> anyhow::Result<()> {
    if args.ids {
        return list_ids(global);
    }
    let mut scenarios = Vec::new();
    for (name, _) in builtin::ALL {
        scenarios.push(Scenario::named(name, &[])?);
    }
    if global.json {
        let entries: Vec<_> = scenarios
            .iter()
            .map(|s| serde_json::json!({"name": s.name, "title": s.title, "ids": s.ids}))
            .collect();
        return super::print(&serde_json::to_string_pretty(&entries)?);
    }
    for scenario in scenarios {
        super::print(&format!("{:<20} {}", scenario.name, scenario.title))?;
    }
    Ok(())
}

fn list_ids(global: &Global) -> anyhow::Result<()> {
    if global.json {
        return super::print(&serde_json::to_string_pretty(&builtin::IDS.as_slice())?);
    }
    let head = format!("{:<4} {:<36} {:<20} {}", "ID", "", "scenario", "figure");
    let row = |shown: &builtin::Shown| {
        format!("{:<4} {:<36} {:<20} {}", shown.id, shown.what, shown.scenario, shown.figure)
    };
    let rows = builtin::IDS.iter().map(row);
    super::print(&std::iter::once(head).chain(rows).collect::<Vec<_>>().join("\n"))
}
