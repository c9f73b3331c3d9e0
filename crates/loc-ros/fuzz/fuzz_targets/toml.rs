//! Files of this project: scenarios, configurations of recordings, topological maps. The first byte
//! says which.
#![no_main]

use libfuzzer_sys::fuzz_target;
use loc_maps::TopologicalMap;
use loc_sim::scenario::{RecordingConfig, Scenario};

fuzz_target!(|data: &[u8]| {
    let Some((kind, rest)) = data.split_first() else { return };
    let text = loc_fuzz::text(rest);
    match kind % 3 {
        0 => drop(Scenario::parse("a.toml", &text, &[])),
        1 => drop(RecordingConfig::parse("a.toml", &text, &[])),
        _ => drop(TopologicalMap::parse_toml("a.toml", &text)),
    }
});
