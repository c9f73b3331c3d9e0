//! Short names of settings, for changes on the command line.
//!
//! The name of what is simulated may be left out: `laser.every_s=0.1` stands for
//! `tour.laser.every_s=0.1` in a scenario with a tour. A few settings that people vary most have
//! names of their own, see [`NAMES`].

use toml::Table;

/// What is simulated, one of these per scenario.
const KINDS: [&str; 7] =
    ["drive", "rail", "tour", "outdoor", "probability_map", "demonstration", "sensor"];

/// The other sections and keys of a scenario.
const OTHERS: [&str; 8] =
    ["name", "title", "ids", "seed", "methods", "filter", "compare", "also_in_frame"];

/// Short names, with the keys that they stand for.
pub(crate) const NAMES: [(&str, &[&str]); 4] = [
    (
        "filter.particles",
        &[
            "filter.mcl.particles.min_particles",
            "filter.mcl.particles.max_particles",
            "filter.landmark_mcl.particles",
        ],
    ),
    ("laser.sigma", &["laser.sigma_m"]),
    ("camera.range_sigma", &["camera.noise.range_sigma_m"]),
    ("camera.bearing_sigma", &["camera.noise.bearing_sigma_deg"]),
];

/// The changes in full.
pub(super) fn expand(config: &Table, changes: &[String]) -> Vec<String> {
    let kind = KINDS.into_iter().find(|kind| config.contains_key(*kind));
    let mut full = Vec::with_capacity(changes.len());
    for change in changes {
        let Some((key, value)) = change.split_once('=') else {
            full.push(change.clone());
            continue;
        };
        let key = key.trim();
        let names = NAMES.iter().find(|(name, _)| *name == key);
        let one = [key];
        for key in names.map_or(one.as_slice(), |(_, keys)| *keys) {
            full.push(format!("{}={value}", within(kind, config, key)));
        }
    }
    full
}

/// A key with the kind of the scenario in front, where it lacks that.
fn within(kind: Option<&str>, config: &Table, key: &str) -> String {
    let first = key.split('.').next().unwrap_or_default();
    let known = KINDS.contains(&first) || OTHERS.contains(&first) || config.contains_key(first);
    match kind {
        Some(kind) if !known && key.contains('.') => format!("{kind}.{key}"),
        _ => key.to_owned(),
    }
}
