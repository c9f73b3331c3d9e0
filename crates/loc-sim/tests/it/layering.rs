//! The house: a crate uses the floors below it, never one above or beside.

use serde_json::Value;
use std::process::Command;

/// The crates from the ground up; those of one list share a floor.
const FLOORS: [&[&str]; 6] = [
    &["loc-core"],
    &["loc-plot", "loc-sensors"],
    &["loc-maps"],
    &["loc-filters", "loc-ros"],
    &["loc-pf"],
    &["loc-sim"],
];

/// Drawing needs poses and nothing else.
const ON_CORE_ALONE: &str = "loc-plot";

fn floor(name: &str) -> Option<usize> {
    FLOORS.iter().position(|floor| floor.contains(&name))
}

#[test]
fn crates_depend_strictly_downward() {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--format-version", "1"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let mut seen = 0;
    for package in metadata["packages"].as_array().unwrap() {
        let name = package["name"].as_str().unwrap();
        // The benches stand outside the house and may look into every room.
        if name == "loc-bench" {
            continue;
        }
        let own = floor(name).unwrap_or_else(|| panic!("{name} has no floor"));
        seen += 1;
        for dependency in package["dependencies"].as_array().unwrap() {
            let used = dependency["name"].as_str().unwrap();
            let below = floor(used).is_none_or(|used| used < own);
            assert!(below, "{name} uses {used}, which is not below it");
            let is_ours = floor(used).is_some();
            assert!(!is_ours || name != ON_CORE_ALONE || used == "loc-core", "{name} uses {used}");
        }
    }
    assert!(seen >= 7);
}

/// No dependency may need a newer Rust than the workspace promises (`rust-version`).
#[test]
fn dependencies_keep_the_minimum_rust_version() {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--locked", "--format-version", "1"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let version = |text: &str| -> Vec<u32> {
        text.split('.').map(|part| part.parse().unwrap_or(0)).take(2).collect()
    };
    let promised = version(env!("CARGO_PKG_RUST_VERSION"));
    for package in metadata["packages"].as_array().unwrap() {
        let Some(needed) = package["rust_version"].as_str() else { continue };
        let name = &package["name"];
        assert!(version(needed) <= promised, "{name} needs Rust {needed}");
    }
}
