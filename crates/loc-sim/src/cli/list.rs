//! `loc-sim list`: the scenarios, a line each.

use super::Global;
use crate::scenario::{Scenario, builtin, ids};

/// List the built-in scenarios, or what each of the lectures' IDs is shown by.
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
        return super::print(&serde_json::to_string_pretty(&ids::ALL.as_slice())?);
    }
    let head = format!("{:<4} {:<36} {:<20} {}", "ID", "", "scenario", "figure");
    let row = |shown: &ids::Shown| {
        format!("{:<4} {:<36} {:<20} {}", shown.id, shown.what, shown.scenario, shown.figure)
    };
    let rows = ids::ALL.iter().map(row);
    super::print(&std::iter::once(head).chain(rows).collect::<Vec<_>>().join("\n"))
}
