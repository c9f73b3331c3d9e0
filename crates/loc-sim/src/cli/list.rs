//! `loc-sim list`: the scenarios, a line each.

use super::Global;
use crate::scenario::{Scenario, builtin};

/// Prints name, title and IDs of every built-in scenario.
///
/// # Errors
/// Those of standard output.
pub fn list(global: &Global) -> anyhow::Result<()> {
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
