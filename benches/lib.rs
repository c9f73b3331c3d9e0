//! What the benches share. Run them with `cargo bench -p loc-bench`, or one of them with
//! `cargo bench -p loc-bench --bench kalman`.

use criterion::Criterion;
use loc_maps::OccupancyGrid;
use loc_maps::grid::io;
use loc_maps::worlds::{self, WorldSettings};
use std::path::Path;
use std::time::Duration;

/// Settings that all benches run with: long enough to be steady, short enough to be rerun.
pub fn criterion() -> Criterion {
    Criterion::default()
        .warm_up_time(Duration::from_secs(1))
        .measurement_time(Duration::from_secs(3))
        .configure_from_args()
}

/// The map that maps are timed on: the one under `LOC_DATA_DIR` on which other localizers were
/// timed (2000 x 2000 cells of 5 cm, 100 rooms, 1200 boxes), else an office of the same size.
///
/// # Errors
/// Where the map cannot be read.
pub fn map() -> loc_maps::Result<OccupancyGrid> {
    match std::env::var_os("LOC_DATA_DIR") {
        Some(folder) => io::load(Path::new(&folder).join("bench/synth.yaml")),
        None => {
            let settings = WorldSettings { width: 2000, height: 2000, resolution: 0.05, seed: 1 };
            Ok(worlds::office(&settings)?.grid)
        }
    }
}
