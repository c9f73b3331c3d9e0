//! Tests of `loc-maps` through its public face, one module per topic.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::float_cmp)]

mod convert;
mod extruded;
mod fields;
mod grid;
mod landmark;
mod line;
#[cfg(feature = "map-server")]
mod map_server;
mod mapping;
mod picture;
mod point;
mod raycast;
#[cfg(feature = "map-server")]
mod real_maps;
mod search;
mod search_input;
#[cfg(feature = "map-server")]
mod search_intel;
mod search_places;
mod topological;
mod worlds;

/// A folder of real recordings under `LOC_DATA_DIR`, or `None`, said aloud, where that is unset.
fn data(folder: &str) -> Option<std::path::PathBuf> {
    let root = std::env::var_os("LOC_DATA_DIR");
    if root.is_none() {
        println!("skipped: LOC_DATA_DIR is not set");
    }
    root.map(|root| std::path::Path::new(&root).join(folder))
}
